"""Every law through every command: an answer, or one line that says why not."""

import itertools
import json
import math
import warnings

import pytest

import fascicle as fs
from fascicle.files import example_text
from fascicle.muscle import LAWS


TASK = """format = 1
[task]
force = ["10 N", "15 N"]
strain = [0.03, 0.06]
supply_pressure = "300 kPa"
[design]
muscle = "muscle.toml"
muscles = [2]
radius = ["11 mm"]
length = ["127 mm"]
braid_angle = ["33 deg"]
wall_ratio = [0.25]
[objectives]
mean_efficiency = "max"
valves = "min"
"""
POINTS = ("--pressure", "0kPa,100kPa", "--strain", "0:0.3:0.1")
DEMAND = ("--force", "15N", "--strain", "0.05")
COMMANDS = {
    "force": ("force", "muscle.toml", *POINTS, "--json"),
    "free-strain": ("free-strain", "muscle.toml", "--pressure", "0kPa,100kPa", "--json"),
    "bundle": ("bundle", "bundle.toml", "--pressure", "100kPa,300kPa", "--json"),
    "space": ("space", "bundle.toml", "--levels", "0kPa,150kPa,300kPa", "--json"),
    "recruit": ("recruit", "bundle.toml", *DEMAND, "--json"),
    "recruit free": ("recruit", "bundle.toml", *DEMAND, "--scheme", "free", "--json"),
    "efficiency": ("efficiency", "bundle.toml", "--json"),
    "simulate": ("simulate", "scenario.toml"),
    "record": ("record", "muscle.toml", "--out", "record.csv", "--samples", "20"),
    "export table": ("export", "bundle.toml", "--table", "table"),
    "design": ("design", "task.toml", "--json"),
}
# as users ask for them: what isn't there by a law's name alone
ASKED = {
    **{f"{kind} {name}": {kind: law()} for kind, laws in LAWS.items()
       for name, law in laws.items()},
    "braid that stretches": {"tension": fs.tension.ElasticBraid(2e8)},
    "ends that give": {"ends": fs.ends.Compliant(5e-3, 1e-5)},
    "ends that hold": {"ends": fs.ends.Compliant(5e-3)},
    "shear": {"buckling": fs.buckling.Elastica(shear="engesser")},
    "braid share": {"buckling": fs.buckling.Kim2021(braid_share=0.5)},
    "all at once": {
        "tension": fs.tension.ElasticBraid(2e8),
        "buckling": fs.buckling.Elastica(0.5, "engesser"),
        "ends": fs.ends.Compliant(5e-3, 1e-5),
    },
}  # fmt: skip
# a law with a command that doesn't take it, and the argument or key that is named
REFUSED = {
    **{(asked, command): "end_compliance"
       for asked in ("ends that give", "all at once")
       for command in ("recruit free", "efficiency", "design")},
    # without pressure they don't push: nothing holds the scenario's mass at rest
    **{(f"tension {name}", "simulate"): "load"
       for name in ("ideal", "meller2014", "tondu_lopez")},
    **{(f"tension {name}", "design"): "tension"
       for name, law in LAWS["tension"].items() if law.reference_muscle},
}  # fmt: skip
# of another muscle's numbers, in a scenario that is too stiff for them
UNTRUSTED = {("tension bolen_20", "simulate")}
WHOLE = list(itertools.product(ASKED, COMMANDS))
# each law by one command, each command by some: those next to one another in both lists
SLOW_ONES = {("all at once", "simulate"), ("tension martens2017_20", "simulate"),
             ("post_collapse consistent", "export table")}  # fmt: skip
SAMPLE = [
    (asked, list(COMMANDS)[i % len(COMMANDS)])
    for i, asked in enumerate(ASKED)
    if (asked, list(COMMANDS)[i % len(COMMANDS)]) not in SLOW_ONES
] + [
    ("ends that give", "efficiency"),
    ("all at once", "bundle"),
    ("tension martens2017_20", "force"),
    ("post_collapse consistent", "force"),
]


def held(fascicle, folder, asked, command):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        muscle = fs.example("kim2021_figure_6").replace(**ASKED[asked])
        fs.save(muscle, folder / "muscle.toml")
        bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, count=2)], 3e5)
        fs.save(bundle, folder / "bundle.toml")
    (folder / "task.toml").write_text(TASK)
    text = example_text("lift_gas").replace('"kim2021_bundle_1_4"', '"bundle.toml"')
    text = text.replace('duration = "6 s"', 'duration = "0.1 s"')
    # where a muscle fills fast a step of 1 ms leaves 2e-5 of its energy, and the run says so
    text = text.replace('dt = "1 ms"', 'dt = "0.25 ms"')
    (folder / "scenario.toml").write_text(text[: text.index("[[schedule]]")] + (
        '[[schedule]]\ntime = "0 s"\ncommand = [1, 0]\n'))  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("default")  # what a law is warned of is said in a line
        code, out, err = fascicle(*COMMANDS[command])
    lines = err.splitlines()
    if (asked, command) in UNTRUSTED:
        assert code == 1 and lines
        return
    assert all(line.startswith(("warning: ", "error: ")) for line in lines), err
    if (asked, command) in REFUSED:
        assert (code, out) == (2, "")
        assert f"`{REFUSED[asked, command]}`" in lines[-1]
        return
    # 3: a demand that it doesn't reach, told with what was found
    assert code in ((0, 3) if command in ("recruit", "recruit free", "design", "bundle") else (0,))
    assert "nan" not in out.lower()
    if "--json" in COMMANDS[command]:
        numbers(json.loads(out))


def numbers(told):
    """Every number of a result is one."""
    if isinstance(told, dict | list):
        for one in told.values() if isinstance(told, dict) else told:
            numbers(one)
    elif isinstance(told, float):
        assert math.isfinite(told)


@pytest.mark.parametrize(("asked", "command"), SAMPLE)
def test_a_law_through_a_command(fascicle, tmp_path, asked, command):
    held(fascicle, tmp_path, asked, command)


@pytest.mark.slow
@pytest.mark.parametrize(("asked", "command"), [one for one in WHOLE if one not in SAMPLE])
def test_every_law_through_every_command(fascicle, tmp_path, asked, command):
    held(fascicle, tmp_path, asked, command)
