import fascicle


# the public face; a name leaves it only through a deprecation
EXPORTS = [
    "Bundle", "Constant", "InvalidInputError", "Joint", "MooneyRivlin", "MotorUnit",
    "Muscle", "MuscleTable", "Switch", "Tuning", "buckling", "calibrate", "catalog", "collapse",
    "control", "design", "dynamics", "ends", "energetics", "example", "examples", "fluid", "laws",
    "load", "materials", "plot", "post_collapse", "records", "recruitment", "reversal", "save",
    "schemes", "tables", "tension",
]  # fmt: skip


def test_public_names():
    assert sorted(fascicle.__all__) == EXPORTS


def test_every_public_name_resolves():
    assert all(getattr(fascicle, name) is not None for name in EXPORTS)


def test_dir_lists_the_lazy_names_too():
    assert set(EXPORTS) <= set(dir(fascicle))
