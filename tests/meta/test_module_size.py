from pathlib import Path

import pytest


SOURCE = Path(__file__).parents[2] / "src/fascicle"
MODULES = sorted(SOURCE.rglob("*.py"))


def test_there_are_modules():
    assert len(MODULES) > 10


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_a_module_holds_one_idea(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 400
