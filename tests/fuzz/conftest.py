"""Lets the tests here import what mutates texts, however pytest was started."""

import sys
from pathlib import Path


sys.path.insert(0, str(Path(__file__).parent))
