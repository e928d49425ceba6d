"""Imports of MuJoCo and MJX, which must have the same version, since they share data."""

import contextlib
import importlib
import io
from importlib import metadata
from types import ModuleType
from typing import Any

from ..core.errors import require


def mjx() -> ModuleType:
    """Import `mujoco.mjx`; raises `ModuleNotFoundError` if it is missing, `ImportError` if its
    version isn't MuJoCo's.
    """
    try:
        installed, required = map(metadata.version, ("mujoco", "mujoco-mjx"))
    except metadata.PackageNotFoundError as error:
        text = f"{error.name} is missing: `pip install 'fascicle[robots]'`."
        raise ModuleNotFoundError(text, name=error.name) from None
    if installed != required:
        raise ImportError(
            f"mujoco {installed} and mujoco-mjx {required} don't go together:"
            f" `pip install mujoco=={required} mujoco-mjx=={required}`."
        )
    with contextlib.redirect_stdout(io.StringIO()):  # MJX prints its missing extras
        return importlib.import_module("mujoco.mjx")


require("mujoco")
mujoco = importlib.import_module("mujoco")
# MuJoCo and MJX ship no types: `MjModel` or `MjSpec`, and `MjData`, or MJX's `Model` and `Data`
Model = Data = Any
