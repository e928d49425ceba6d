"""`fascicle init` for what makers buy."""

import fascicle as fs


def test_a_sleeve_and_a_tube_make_a_muscle(fascicle, refused, tmp_path):
    line = ("init", "m.toml", "--sleeve", "12 mm at 40 deg", "--tube", "9x7 mm")
    code, _, err = fascicle(*line)
    assert (code, err) == (0, "")
    muscle = fs.load(tmp_path / "m.toml")
    made = fs.Muscle.from_sleeve("127 mm", "12 mm", "40 deg", "9 mm", "1 mm")
    # the file has the angle to a hundredth of a degree
    assert abs(float(muscle.braid_angle - made.braid_angle)) < 1e-4
    assert float(muscle.outer_radius) == 4.5e-3
    fascicle("init", "n.toml", "--sleeve", "9 mm", "--tube", "9 mm x 7 mm")
    assert "assumed" in (tmp_path / "n.toml").read_text()
    refused("init o.toml --tube 9x7mm")
    for sizes in (("9 mm", "9x0 mm"), ("9 mm at 80 deg", "9x7 mm")):  # a rod, an extensor
        code, _, err = fascicle("init", "o.toml", "--sleeve", sizes[0], "--tube", sizes[1])
        assert code == 2 and "--sleeve" in err and not (tmp_path / "o.toml").exists()
    refused("init o.toml --sleeve 9mm --tube 9mm")


def test_a_thread_and_its_turns_make_a_muscle(fascicle, refused, tmp_path):
    line = ("--thread", "277.1 mm", "--turns", "1.5", "--length", "264.1 mm")
    code, printed, err = fascicle(
        "init", "m.toml", *line, "--tube", "17x15 mm", "--material", "silicone_kim2021"
    )
    assert (code, err) == (0, "") and "assumed" not in printed
    made = fs.Muscle.from_thread(0.2641, 0.2771, 1.5, 1e-3, material="silicone_kim2021")
    assert fs.load(tmp_path / "m.toml") == made
    assert "assumed" in fascicle("init", "n.toml", *line)[1]
    for options in (
        "--thread 277mm --turns 1.5",  # whose angle would be that of an assumed length
        "--thread 200mm --turns 1.5 --length 264mm",
        "--length 264mm --task",
        "--material nylon",
        "--tube 9x7mm",
        "--thread 277mm --turns 1.5 --length 264mm --sleeve 9mm --tube 9x7mm",
    ):
        refused(f"init o.toml {options}")
    assert not (tmp_path / "o.toml").exists()


def test_the_protractor_has_its_true_size(fascicle, tmp_path):
    assert fascicle("init", "--protractor", "strip.svg")[0] == 0
    text = (tmp_path / "strip.svg").read_text()
    width = float(text.split('width="')[1].split("pt")[0]) / 72 * 25.4
    assert abs(width - 172) < 0.01  # mm
