"""Version of the installed package; pyproject.toml alone has it."""

from importlib import metadata  # a tenth of the time of the command line's help


try:
    __version__ = metadata.version("fascicle")
except metadata.PackageNotFoundError:  # run from a folder that was never installed
    __version__ = "0+unknown"
