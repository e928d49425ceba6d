"""A muscle is named by an example, an entry of the catalog, or the path of a file, everywhere."""

import pytest

import fascicle as fs
from fascicle.files import loads
from refusing import refuses


UNIT = "[[bundle.motor_unit]]\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "fit").mkdir()
    muscle = fs.example("kim2021_figure_6").replace(length=0.12)
    fs.save(muscle, tmp_path / "fit" / "muscle.toml")
    return tmp_path


def load(folder, text):
    (folder / "b.toml").write_text(f"format = 1\n{text}")
    return fs.load(folder / "b.toml")


def lengths(bundle):
    return [float(unit.muscle.length) for unit in bundle.motor_units]


def test_a_file_names_its_muscle(folder):
    assert load(folder, 'muscle = "fit/muscle.toml"').length == 0.12
    assert load(folder, 'muscle = "kim2021_figure_6"') == fs.example("kim2021_figure_6")
    bundle = load(folder, f'muscle = "fit/muscle.toml"\n{UNIT}count = 2\n{UNIT}')
    assert lengths(bundle) == [0.12, 0.12] and bundle.motor_units[0].count == 2


def test_named_muscles_and_motor_units_name_files(folder):
    text = '[muscle]\na = "fit/muscle.toml"\nb = "fit/muscle.toml"\n'
    assert lengths(load(folder, f'{text}{UNIT}muscle = "b"\n{UNIT}muscle = "a"\n')) == [0.12] * 2
    unit = f'{UNIT}muscle = "fit/muscle.toml"\n'
    bundle = load(folder, unit + unit)
    assert lengths(bundle) == [0.12] * 2
    assert bundle.motor_units[0].muscle is bundle.motor_units[1].muscle


def test_a_scenario_names_it(folder):
    text = (
        'format = 1\nmuscle = "fit/muscle.toml"\n[load]\nkind = "hanging_mass"\nmass = "1 kg"\n'
        '[fluid]\nmedium = "air"\n[supply]\nkind = "constant"\npressure = "4 bar"\n[valve]\n'
        'kind = "sonic_valve"\nb = 0.3\nC = "1 L/(s bar)"\n'
        '[run]\nduration = "1 s"\n[[schedule]]\ntime = "0 s"\ncommand = 1\n'
    )
    (folder / "s.toml").write_text(text)
    assert lengths(fs.load(folder / "s.toml").plant.bundles[0]) == [0.12]


def test_what_names_none_is_one_line(folder):
    for text, key in (
        ('muscle = "nowhere.toml"', "muscle"),
        ('muscle = "b.toml"', "muscle"),  # itself: a named file names no files
        (f'{UNIT}muscle = "nowhere.toml"', "bundle.motor_unit[0].muscle"),
    ):
        with refuses(key):
            load(folder, text)


def test_a_text_from_elsewhere_names_no_files(folder, monkeypatch):
    monkeypatch.chdir(folder)
    assert loads('format = 1\nmuscle = "kim2021_figure_6"') == fs.example("kim2021_figure_6")
    with refuses("muscle"):
        loads('format = 1\nmuscle = "fit/muscle.toml"')
