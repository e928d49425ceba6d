"""Libraries that an optional extra brings: what is missing, and the command that installs it."""

from importlib.util import find_spec


_EXTRAS = {
    "jax": "jax", "jaxlib": "jax", "equinox": "jax", "diffrax": "jax", "matplotlib": "plot",
    "pandas": "data", "xarray": "data", "netCDF4": "data", "moocore": "design", "pymoo": "design",
    "optax": "design", "SALib": "design", "dask": "sweep", "zarr": "sweep", "panel": "explorer",
    "bokeh": "explorer", "tornado": "explorer", "casadi": "export", "mujoco": "robots",
    "gymnasium": "robots", "numpyro": "posterior",
}  # fmt: skip


class MissingExtraError(ImportError):
    """A library that isn't installed, and the command that installs it."""


def missing_extra(error: BaseException) -> MissingExtraError | None:
    """What to say of an import that failed [-]; `None` for what no extra brings.

    **Arguments:** `error`: it [-].

    **Returns:** an error in one line, with the command that installs the library [-].
    """
    library = (getattr(error, "name", None) or "").split(".")[0]
    if not isinstance(error, ModuleNotFoundError) or library not in _EXTRAS:
        return None
    message = f"{library} is not installed: pip install 'fascicle[{_EXTRAS[library]}]'"
    return MissingExtraError(message, name=library)


def require(library: str) -> None:
    """Refuse, in one line, where a library is not installed.

    **Arguments:** `library`: what it is imported as [-].

    **Raises:** `MissingExtraError` with the command that installs it.
    """
    if find_spec(library) is None:
        raise missing_extra(ModuleNotFoundError(name=library)) or ImportError(library)
