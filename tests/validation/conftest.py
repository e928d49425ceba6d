"""Lets the tests here import the oracle beside them, however pytest was started."""

import sys
from pathlib import Path

import pytest


sys.path.insert(0, str(Path(__file__).parent))

from oracle_random import random_cases


@pytest.fixture
def random_muscles():
    """`random_muscles(seed, n)`: random muscles with a pressure and strains each."""
    return random_cases
