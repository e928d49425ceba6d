"""Files of records: to the bit and back, the schema of JSON, and versions."""

import json
import math
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from fascicle import records
from fascicle.cli import main
from fascicle.records.published import SCHEMA, to_json
from refusing import refuses_at


ROOT = Path(__file__).parents[3]
RNG = np.random.default_rng(5)
COUNT = 40
BARE = records.Record.of(RNG.uniform(0, 1e6, COUNT), RNG.uniform(-0.2, 0.9, COUNT),
                         RNG.normal(0, 50, COUNT))  # fmt: skip
FULL = replace(
    BARE, censored=RNG.random(COUNT) < 0.3, branch=RNG.integers(-1, 2, COUNT).astype(np.int8),
    time=np.cumsum(RNG.random(COUNT)), moment_arm=RNG.random(COUNT) / 30, rest_length=math.pi / 10,
    synthetic=True, sources=(records.Source("a b.csv", "0f" * 32),), notes=("ε: “x”\n", ""),
)  # fmt: skip
# least and largest floats of the domain, and a negative zero
ENDS = records.Record.of([0.0, 5e-324, 1e6], [-0.2, 0.9, -0.0], [1.7976931348623157e308, -0.0, 0.1])


@pytest.mark.parametrize(
    ("record", "suffix"),
    [(BARE, ".json"), (FULL, ".json"), (ENDS, ".json"), (BARE, ".csv"), (FULL, ".csv"),
     (replace(ENDS, strain=np.full(3, 0.1 + 0.2), force=np.array([1e-300, -0.0, 1 / 3])), ".csv")],
)  # fmt: skip
def test_it_reads_back_to_the_bit(record, suffix, tmp_path):
    path = tmp_path / f"r{suffix}"
    records.write(record, path)
    read = records.load(path)
    for field in fields(record):
        before, after = getattr(record, field.name), getattr(read, field.name)
        if isinstance(before, np.ndarray):
            assert (before.dtype, before.tobytes()) == (after.dtype, after.tobytes()), field.name
        elif suffix == ".json" or field.name not in ("sources", "notes", "findings"):
            assert before == after and type(before) is type(after), field.name
    again = tmp_path / f"again{suffix}"
    records.write(read, again)
    count = 0 if suffix == ".json" else -len(record)  # a CSV's remarks grow
    assert again.read_text().splitlines()[count:] == path.read_text().splitlines()[count:]


def test_sources_and_notes_go_along_in_a_csv():
    notes = records.loads(records.dumps(FULL), source="m.csv").notes
    assert {f"m.csv: source: a b.csv sha256 {'0f' * 32}", "m.csv: note: ε: “x”"} <= set(notes)


@pytest.mark.parametrize(
    ("key", "value", "place"),
    [
        ("schema", "fascicle-record/2", "schema"), ("schema", None, "schema"),
        ("strian", [1.0], "strian"), ("force", None, "force"), ("force", [1.0], "force"),
        ("pressure", [1e7] * COUNT, "pressure[0]"), ("strain", ["0.1"] * COUNT, "strain[0]"),
        ("strain", [math.nan] * COUNT, "strain[0]"), ("branch", [2] * COUNT, "branch[0]"),
        ("sources", [{"name": "a", "sha256": "xyz"}], "sources[0].sha256"),
        ("rest_length", 0.0, "rest_length"), ("synthetic", "no", "synthetic"),
    ],
)  # fmt: skip
def test_bad_files_are_refused_by_key(key, value, place):
    data = json.loads(to_json(FULL)) | {key: value}
    text = json.dumps({key: value for key, value in data.items() if value is not None})
    with refuses_at(f"r.json: {place}"):
        records.loads(text, "r.json")


def test_options_of_tables_do_not_apply():
    for options in ({"units": {"force": "N"}}, {"rest_length": 0.2}):
        with refuses_at("r.json"):
            records.loads(to_json(FULL), "r.json", **options)
    assert records.loads(to_json(BARE), "r.json", rest_length=0.2).rest_length == 0.2


def test_the_schema_in_the_docs_is_the_code_s():
    path = ROOT / f"docs/_static/{SCHEMA.replace('/', '-')}.schema.json"
    assert json.loads(path.read_text()) == records.json_schema()
    described = set(records.json_schema()["properties"])
    of_reading = {"findings", "zeroed", "file"}
    assert described == {"schema", *(f.name for f in fields(records.Record))} - of_reading


def test_formats_convert(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("b.txt").write_text("pressure [kPa];strain [%];force [N]\n100;1,5;33,3\n")
    direct = records.load("b.txt")
    for out, more in (("b.json", []), ("b2.csv", []), ("b.json", ["--overwrite"])):
        with pytest.raises(SystemExit) as end:
            main(["convert", "b.txt", "--out", out, *more])
        read = records.load(out)
        assert not end.value.code
        for name in ("pressure", "strain", "force"):
            assert getattr(read, name).tobytes() == getattr(direct, name).tobytes()
    assert records.load("b.json").sources == direct.sources
