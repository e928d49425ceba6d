"""The function block in Structured Text has the table's force, and finds pressures on it."""

import re

import numpy as np
import pytest

import fascicle as fs
from fascicle.export import function_block


TOP = 413.7e3
MEETS = 2e-10  # N, in the block
TOLERANCE = 1e-12  # of rounding, as of the table in C
# Structured Text in the words of Python, which has its operators, arrays and indentation
WORDS = {
    r"\(\*.*?\*\)|;|\bEND_\w+": "",
    r"\bELSIF (.*?) THEN": r"elif (\1):",
    r"\bIF (.*?) THEN": r"if (\1):",
    r"\bELSE\b": "else:",
    r"\bFOR (\w+) := (.*?) TO (.*?) DO": r"for \1 in range(\2, \3 + 1):",
    r"\) = \(": ") == (",
    r"<>": "!=",
    r":=": "=",
    r"\bAND\b": "and",
}
FUNCTIONS = {"TRUNC": int, "SQRT": np.sqrt, "MIN": min, "MAX": max, "ABS": abs}


def read_block(text):
    """The block as a Python function of its inputs, and its array."""
    real = np.float64 if "LREAL" in text else np.float32
    conversions = {"DINT_TO_LREAL": np.float64, "DINT_TO_REAL": np.float32}
    constants = {
        name: int(value) if kind == "DINT" else real(value)
        for name, kind, value in re.findall(r"(\w+) : (\w+) := ([^\s\[]+);", text)
    }
    shape = [int(last) + 1 for last in re.findall(r"0\.\.(\d+)", text)]
    nodes = np.array(re.findall(r"NODES .*?\[\n(.*?)\]", text, re.DOTALL)[0].split(","), real)
    body = text[text.rindex("END_VAR") + len("END_VAR") :]
    for pattern, word in WORDS.items():
        body = re.sub(pattern, word, body, flags=re.DOTALL)
    code = compile(body, "block", "exec")

    def call(**inputs):
        values = {**FUNCTIONS, **conversions, **constants, "NODES": nodes.reshape(shape)}
        values |= {name: real(value) for name, value in inputs.items()}
        exec(code, values)  # noqa: S102 the library's own text
        return [values[name] for name in ("status", "force", "setpoint", "reached")]

    return call


def first_crossing(table, strain, demand, supply):
    """Status, and lowest and highest pressure of the answer, from forces at the table's lines."""
    lines = (float(table.root_step) * np.arange(table.coefficients.shape[0] + 1)) ** 2
    P = np.append(lines[lines < supply], supply)
    excess = table.force(P, strain) - demand
    if len(change := np.flatnonzero(np.diff(excess > 0))):
        return 0, P[change[0]], P[change[0] + 1]
    nearest = np.argmin(np.abs(excess))
    return 1 if excess[nearest] < 0 else 2, P[nearest], P[nearest]


@pytest.mark.parametrize("laws", [{}, {"tension": "ideal", "collapse": "wood1958"}])
def test_force_and_setpoint_are_those_of_the_table(laws, make_muscle):
    muscle = make_muscle(**laws)
    table = muscle.table(TOP, shape=(17, 21))
    call = read_block(function_block(muscle, "arm", highest_pressure=TOP, shape=(17, 21)))
    rng = np.random.default_rng(3)
    low, high = map(float, table.strains)
    largest, statuses = float(muscle.force(TOP, 0.0)), set()
    for k in range(600):
        strain, P, supply = rng.uniform((low, -1e4, 0.02 * TOP), (high, TOP, TOP))
        demand = rng.uniform(-0.05, 0.1 if k % 2 else 1.2) * largest
        status, force, setpoint, reached = call(
            strain=strain, pressure=P, demand=demand, supply=supply
        )
        expected, lowest, highest = first_crossing(table, strain, demand, supply)
        statuses.add(status)
        assert abs(force - table.force(P, strain)) <= TOLERANCE * (abs(force) + 1)
        assert abs(reached - table.force(setpoint, strain)) <= TOLERANCE * (abs(reached) + 1)
        assert status == expected and (status or abs(reached - demand) <= MEETS)
        assert lowest * (1 - TOLERANCE) <= setpoint <= highest * (1 + TOLERANCE)
    assert statuses == {0, 1, 2}


def test_inputs_outside_of_the_table_have_a_status(make_muscle):
    call = read_block(function_block(make_muscle(), highest_pressure=TOP, shape=(17, 21)))
    inside = {"strain": 0.1, "pressure": 1e5, "demand": 50.0, "supply": 2 * TOP}
    assert call(**inside)[0] == 0
    for name, value in (
        ("strain", -0.3), ("strain", 0.61), ("pressure", -2e5), ("pressure", 1.01 * TOP),
        ("supply", 0.0), *((name, np.nan) for name in inside),
    ):  # fmt: skip
        assert call(**inside | {name: value}) == [3, 0, 0, 0]


def test_single_precision_is_off_by_no_more_than_it_states(make_muscle):
    text = function_block(make_muscle(), "arm", "float", TOP)
    assert "LREAL" not in text
    rounding = float(re.search(r"rounding adds up to ([\d.e+-]+) N", text)[1])
    table, call = make_muscle().table(TOP, shape=(33, 41)), read_block(text)
    P, strain = np.random.default_rng(3).uniform((0, 0), (TOP, 0.3), (200, 2)).astype("f").T
    for point in zip(P, strain, strict=True):
        _, force, *_ = call(strain=point[1], pressure=point[0], demand=0.0, supply=TOP)
        assert force.dtype == "f" and abs(force - table.force(*point)) <= rounding


def test_a_parser_of_iec_61131_3_reads_it(make_muscle):
    reason = "tree-sitter and its grammar of Structured Text aren't installed"
    tree_sitter = pytest.importorskip("tree_sitter", reason=reason)
    grammar = pytest.importorskip("tree_sitter_iec61131_3_st", reason=reason)
    parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
    text = function_block(make_muscle(), "arm", "float", TOP)
    assert not parser.parse(text.encode()).root_node.has_error
    assert parser.parse(text.replace("END_FOR;", "").encode()).root_node.has_error


def test_a_bundle_and_other_names_are_refused(make_muscle):
    for target, options in ((fs.example("kim2021_bundle_1_4"), {}), (make_muscle(), {"name": "1"})):
        with pytest.raises(fs.InvalidInputError):
            function_block(target, **options)
