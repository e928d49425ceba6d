"""Mutated records of a dynamometer: each is read, or refused in one line that names it."""

import warnings

import numpy as np
import pytest
from mutations import SIGNS

from fascicle import records


CELLS = [
    "", "0", "-0", "1e999", "nan", "inf", "-1", "1e300", "1,5", "1.5", "a", '"', "1e-300", "#",
    "0x10", "1_0", "\u202e", "9" * 400, "=1+1", "1e5", "5000", "-0.5", " 1 ", "1 kPa",
]  # fmt: skip
HEADS = [
    "pressure [Pa]", "pressure [kPa]", "strain [-]", "strain [%]", "force [N]", "force [kN]",
    "length [mm]", "time [s]", "Druck (bar)", "F", "", "pressure", "displacement [mm]", "branch",
    "clipped", "pressure [furlong]", "x" * 500, "\u202e", "force [N]",
]  # fmt: skip


def table(rng):
    """A small record as some lab would have written it."""
    rows = int(rng.integers(4, 40))
    P = np.repeat([0.0, 1e5, 2e5], rows)
    strain = np.tile(np.linspace(0, 0.2, rows), 3)
    force = 3e-4 * P * (0.25 - strain) * 4 + rng.normal(size=P.size)
    lines = ["pressure [Pa],strain [-],force [N]"]
    lines += [f"{p:.6g},{e:.6g},{f:.6g}" for p, e, f in zip(P, strain, force, strict=True)]
    return lines


def mutated(rng):
    lines = table(rng)
    for _ in range(rng.integers(1, 5)):
        kind, place = rng.integers(10), int(rng.integers(len(lines)))
        cells = lines[place].split(",")
        at = int(rng.integers(len(cells)))
        if kind < 3:
            cells[at] = str(rng.choice(CELLS))
            lines[place] = ",".join(cells)
        elif kind == 3:
            heads = lines[0].split(",")
            heads[int(rng.integers(len(heads)))] = str(rng.choice(HEADS))
            lines[0] = ",".join(heads)
        elif kind == 4:
            del lines[place]
        elif kind == 5:
            lines.insert(place, str(rng.choice(["", "# note: x", ",", ",,", "text", lines[0]])))
        elif kind == 6:
            delimiters = [str(x) for x in rng.choice([";", "\t", " ", "|"], len(lines))]
            lines = list(map(str.replace, lines, [","] * len(lines), delimiters))
        elif kind == 7:
            sign = str(rng.choice(SIGNS))
            cut = int(rng.integers(len(lines[place]) + 1))
            lines[place] = lines[place][:cut] + sign + lines[place][cut:]
        elif kind == 8:
            lines = lines[: place + 1]
        else:
            lines[place] = ",".join([*cells, "1"])
        lines = lines or [""]
    ending = str(rng.choice(["\n", "\n", "\r\n", "\r"]))
    return ending.join(lines).encode(
        str(rng.choice(["utf-8", "utf-8", "utf-16", "latin-1"])), "replace"
    )


def named(message, name):
    assert (message.count(name) > 0, message.count("\n")) == (True, 0), message


def check(seed, count, path):
    rng, taken = np.random.default_rng(seed), 0
    for _ in range(count):
        path.write_bytes(mutated(rng))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                record = records.load(path, rest_length=0.3)
        except (ValueError, OSError) as error:
            named(str(error), path.name)
            continue
        taken += 1
        for values in (record.pressure, record.strain, record.force):
            assert np.all(np.isfinite(values))
        assert np.all((record.pressure >= 0) & (record.pressure <= 1e6))
        assert np.all((record.strain >= -0.2) & (record.strain <= 0.9))
    assert 0.01 * count < taken < 0.9 * count


@pytest.mark.parametrize(
    ("seed", "count"), [(0, 120), pytest.param(1, 6000, marks=pytest.mark.slow)]
)
def test_records(tmp_path, seed, count):
    check(seed, count, tmp_path / "x.csv")
