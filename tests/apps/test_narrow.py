"""Tables on a narrow terminal: one where it can be, and parts whose rows are still named."""

import pytest

from fascicle.cli.outputs import print_table


FIVE, PAIR = "kim2021_bundle_five", "kim2021_bundle_1_4"


@pytest.fixture
def printed(fascicle, monkeypatch):
    """Lines that a command prints on a terminal of this width."""

    def run(width, *arguments):
        monkeypatch.setenv("COLUMNS", str(width))
        _, out, _ = fascicle(*arguments)
        lines = out.splitlines()
        assert max(map(len, lines)) <= width
        return lines

    return run


def test_each_part_of_a_recruitment_says_force_and_strain(printed):
    lines = printed(60, "recruit", FIVE, "-f", "20N,100N", "-s", "0.1")
    starts = [line.split()[:2] for line in lines if line.lstrip()[:3] in ("20 ", "100")]
    assert starts == [["20", "0.1"], ["100", "0.1"]] * 2
    assert sum(line.split()[1:2] == ["strain"] for line in lines) == 2


def test_balances_are_one_table(printed):
    lines = printed(60, "simulate", "lift_gas")
    assert lines.count("Balances") == 1
    assert sum(line.rstrip().endswith("closes") for line in lines) == 5


def test_the_longer_of_strains_and_forces_runs_down_the_page(printed):
    lines = printed(100, "efficiency", PAIR, "--force", "20N", "--path", "isobaric")
    assert lines.count("Efficiency, isobaric, by strain") == 1
    assert any(line.split() == ["strain", "20", "N"] for line in lines)
    forces = ("--force", "5N:50N:5N", "--strain", "0.05,0.1")
    lines = printed(100, "efficiency", PAIR, *forces, "--path", "isobaric")
    assert any(line.split() == ["force", "N", "0.05", "0.1"] for line in lines)
    assert sum(line.split()[:1] == ["50"] for line in lines) == 1


def test_first_columns_stand_beside_every_part(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "24")
    heads = ["aa", "bb", *(f"c{i}wide" for i in range(5))]
    print_table("Title", heads, [[*"12", *("9.9999" for _ in range(5))]], keys=2)
    lines = capsys.readouterr().out.splitlines()
    tops = [line.split() for line in lines if "wide" in line]
    assert len(tops) > 1 and all(top[:2] == ["aa", "bb"] for top in tops)
    assert [one for top in tops for one in top[2:]] == heads[2:]
