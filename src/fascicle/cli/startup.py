"""JAX as a command wants it: quiet, on the CPU, with its compiled functions kept on disk."""

import logging
import os
import sys
import warnings
from pathlib import Path
from typing import Any

import wrapt

from ..core.jax_settings import enable_whole_loops
from .interrupts import at_once
from .problems import UserError
from .telling import telling


def prepare() -> None:
    """Set JAX up for one command; call it before the laws are imported.

    A command evaluates a few thousand points: starting a GPU would take longer than that.
    `JAX_PLATFORMS`, if set, is respected. `FASCICLE_NO_CACHE=1` keeps nothing on disk.
    """
    enable_whole_loops()
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")  # XLA's own log, on stderr
    for name in ("jax", "matplotlib"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    warnings.filterwarnings("ignore", module=r"jax(lib)?(\.|$)")  # not what jaxtyping calls
    with telling("loading the laws"):
        _load()


def _load() -> None:
    """Import all laws, and have JAX configured if anything imports it."""
    if os.environ.get("JAX_PLATFORMS", "cpu") not in ("", "cpu"):
        with at_once():
            import jax  # noqa: F401 a device that is asked for is looked for now
        _check_platforms()
    wrapt.register_post_import_hook(_configure, "jax")
    with at_once():
        from ..core.validation import disable_pressure_unit_warning
        from ..files import reading  # noqa: F401 and with it all laws
    disable_pressure_unit_warning()  # options and files have their units


def _configure(jax: Any) -> None:
    if not os.environ.get("JAX_PLATFORMS"):
        jax.config.update("jax_platforms", "cpu")  # always there; others take time to start
    if (folder := cache_folder()) is not None:
        jax.config.update("jax_compilation_cache_dir", str(folder))
        # below this, reading the file costs as much as compiling
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)


def _check_platforms() -> None:
    """Refuse a `JAX_PLATFORMS` that isn't there, before it fails somewhere in the laws."""
    import jax

    try:
        jax.devices()
    except Exception:  # noqa: BLE001 a RuntimeError, an AssertionError, as the plugin has it
        asked = os.environ["JAX_PLATFORMS"]
        raise UserError(
            f"JAX_PLATFORMS={asked}: JAX finds no such device; unset it, or write cpu."
        ) from None


def cache_folder() -> Path | None:
    """Where compiled functions are kept [-], or `None` where they can't be."""
    if os.environ.get("FASCICLE_NO_CACHE", "") not in ("", "0"):
        return None
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA", "")
    else:
        base = os.environ.get("XDG_CACHE_HOME", "") or "~/.cache"
    try:
        folder = Path(base, "fascicle", "compiled").expanduser()
        if not folder.is_absolute():
            return None
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".{os.getpid()}"
        probe.touch()
        probe.unlink()
    except (OSError, RuntimeError, ValueError):  # RuntimeError: no home
        return None
    return folder
