"""Turns the package's annotations into checks, before anything imports it."""

from jaxtyping import install_import_hook


install_import_hook("fascicle", "beartype.beartype")
