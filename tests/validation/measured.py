"""Where measured data lie that the repository doesn't hold: `FASCICLE_DATA`, or beside it."""

import os
from pathlib import Path

import pytest


def measured(name):
    """Path of a measured file, or a skipped test."""
    checkout = Path(__file__).parents[2]
    folder = Path(os.environ.get("FASCICLE_DATA") or checkout.parent / "shared" / "data")
    path = folder / name
    if not path.is_file():
        pytest.skip(f"no {name} in FASCICLE_DATA or beside the checkout")
    return path
