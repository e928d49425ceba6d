"""What an import costs: laws and the commands for them load no JAX."""

import ast
import json
import subprocess
import sys
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import fascicle


HEAVY = {
    "dask", "fascicle.cli", "IPython", "matplotlib", "moocore", "netCDF4", "pandas", "panel",
    "pint", "plotly", "pydantic", "rich", "scipy", "tomlkit", "typer", "xarray", "zarr",
}  # fmt: skip


SOURCE = Path(fascicle.__file__).parent
WITHOUT = {"jax", "jaxlib", "equinox", "diffrax", "jaxtyping"}
BUNDLE, MUSCLE = "kim2021_bundle_1_4", "kim2021_figure_6"


def loaded(statements: str) -> set[str]:
    """Modules that a fresh interpreter holds after `statements`."""
    code = f"import json, sys\n{statements}\nprint('\\n' + json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stdout.splitlines()[-1]))


# laws first, which load least; then what else needs no JAX, each asked after its work
WORK = f"""
import fascicle as fs
from fascicle import control
from fascicle.cli import main
from fascicle.design import Space, Task, Uncertainty, judge_safety, search

bundle = fs.example({BUNDLE!r})
space = Space({{"m": fs.example({MUSCLE!r})}}, (2, 3))

def command(line):
    try:
        main(line.split())
    except SystemExit as end:
        assert end.code in (0, None), line

for name, work in {{
    "dips": lambda: control.needed_reserve(bundle, 0.2, 10.0, 0.1),
    "designs": lambda: judge_safety(
        search(space, Task.of([60.0], [0.1], 413.7e3)), Uncertainty(draws=20)
    ),
    **{{line: lambda line=line: command(line) for line in LINES}},
}}.items():
    work()
    assert not WITHOUT & set(sys.modules), name
"""
LINES = [
    f"force {MUSCLE} --pressure 200kPa --strain 0.1",
    f"free-strain {MUSCLE} --pressure 200kPa",
    f"bundle {BUNDLE} --pressure 300kPa,100kPa --strain 0.1",
    f"recruit {BUNDLE} --force 60N --strain 0.1",
    f"space {BUNDLE}",
    f"efficiency {BUNDLE}",
    *(f"export {name} --table FOLDER/{name}" for name in (MUSCLE, BUNDLE)),
]


def test_the_laws_load_no_files_results_or_pictures():
    modules = loaded(
        "import fascicle as fs\n"
        f"assert not {HEAVY!r} & set(sys.modules)\n"
        "m = fs.Muscle("
        "length=0.127, outer_radius=6.35e-3, wall_thickness=1.6e-3, braid_angle=0.576)\n"
        "m.force(1e5, 0.1)\n"
        "fs.Bundle([fs.MotorUnit(m)]).force([1e5], 0.1)"
    )
    assert not modules & (HEAVY | WITHOUT)


def test_commands_for_laws_dips_and_searches_for_designs_load_no_jax(tmp_path):
    lines = [line.replace("FOLDER", str(tmp_path)) for line in LINES]
    loaded(f"LINES, WITHOUT = {lines!r}, {WITHOUT!r}\n{WORK}")


def test_rooms_on_jax_name_the_extra_where_it_is_missing():
    loaded(
        "import importlib\nfrom fascicle.core.errors import MissingExtraError\n"
        "sys.modules['jax'] = None\n"
        "for room in ('jax', 'dynamics', 'robots'):\n"
        "    try:\n        importlib.import_module(f'fascicle.{room}')\n"
        "    except MissingExtraError as error:\n        assert error.name == 'jax'\n"
        "    else:\n        raise AssertionError(room)"
    )


def test_help_loads_no_jax():
    without = {"jax", "jaxlib", "equinox", "numpy", "xarray", "matplotlib", "pint"}
    loaded(
        "from fascicle.cli import main\ntry:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        f"assert not {without!r} & set(sys.modules)"
    )


def test_importing_leaves_the_environment_alone():
    loaded(
        "import os, jax\nbefore = dict(os.environ)\n"  # JAX has settings of its own
        "import fascicle as fs\nfs.example('kim2021_figure_6').force(1e5, 0.1)\n"
        "assert dict(os.environ) == before"
    )


def imports_at_the_top(path: Path) -> Iterator[str]:
    """Modules that a module of fascicle imports as it is imported, without those for types."""
    package = [*path.relative_to(SOURCE.parent).with_suffix("").parts]
    nodes = list(ast.parse(path.read_text(encoding="utf-8")).body)
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            nodes += node.orelse
        elif isinstance(node, ast.If | ast.Try | ast.With):
            nodes += [entry for entry in ast.iter_child_nodes(node) if isinstance(entry, ast.stmt)]
        elif isinstance(node, ast.ImportFrom) and node.level:
            home = [*package[: -node.level], *(node.module.split(".") if node.module else [])]
            yield ".".join(home)
            yield from (".".join([*home, name.name]) for name in node.names)


def test_no_modules_import_one_another_in_a_circle():
    """The layers hold it between rooms, this inside; imports for types alone don't count."""
    paths = {
        ".".join(path.relative_to(SOURCE.parent).with_suffix("").parts): path
        for path in SOURCE.rglob("*.py")
    }
    graph = {
        name: {target for target in imports_at_the_top(path) if target in paths and target != name}
        for name, path in paths.items()
        if path.stem != "__init__"
    }
    assert sum(map(len, graph.values())) > 500
    TopologicalSorter(graph).prepare()  # raises `CycleError` with the circle
