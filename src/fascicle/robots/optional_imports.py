"""MuJoCo and MJX, where they are installed, and of one version: data go from one to the other."""

import contextlib
import importlib
import io
from importlib import metadata
from typing import Any


_INSTALL = "pip install 'fascicle[robots]'"


def _found(name: str, what: str) -> Any:
    try:
        # MJX prints what of its own extras is missing
        with contextlib.redirect_stdout(io.StringIO()):
            return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not name.startswith(error.name):
            raise
        raise ModuleNotFoundError(f"{what} is missing: `{_INSTALL}`.", name=error.name) from None


def mjx() -> Any:
    """The module `mujoco.mjx` [-]; `ModuleNotFoundError` where it is missing, `ImportError` where
    it is of another version than MuJoCo.
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
    return _found("mujoco.mjx", "MJX")


mujoco: Any = _found("mujoco", "MuJoCo")
