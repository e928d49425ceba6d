"""Imports of MuJoCo and MJX, which must have the same version, since they share data."""

import contextlib
import importlib
import io
from importlib import metadata
from typing import Any


_INSTALL = "pip install 'fascicle[robots]'"


def _import_or_explain(name: str, label: str) -> Any:
    """A module, silently; where it is missing, an error that says how to install it."""
    try:
        # MJX prints its missing extras
        with contextlib.redirect_stdout(io.StringIO()):
            return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not name.startswith(error.name):
            raise
        raise ModuleNotFoundError(f"{label} is missing: `{_INSTALL}`.", name=error.name) from None


def mjx() -> Any:
    """Import `mujoco.mjx`; raises `ModuleNotFoundError` if it is missing, `ImportError` if its
    version isn't MuJoCo's.
    """
    versions = {}
    for name in ("mujoco", "mujoco-mjx"):
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            raise ModuleNotFoundError(f"{name} is missing: `{_INSTALL}`.", name=name) from None
    installed, required = versions["mujoco"], versions["mujoco-mjx"]
    if installed != required:
        raise ImportError(
            f"mujoco {installed} and mujoco-mjx {required} don't go together:"
            f" `pip install mujoco=={required} mujoco-mjx=={required}`."
        )
    return _import_or_explain("mujoco.mjx", "MJX")


mujoco: Any = _import_or_explain("mujoco", "MuJoCo")
