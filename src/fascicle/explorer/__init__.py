"""The explorer: the same laws in a browser, or in a notebook.

Views are computed as arrays (`…_curves`, `…_space`, `tube`) by the laws and shown by widgets
(`…_view`); what a session shows is one immutable `View`, which its address holds. Names are
looked up when they are asked for, so that the command line's help loads no Panel.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from .page import panel as panel
    from .server import serve as serve

_HOMES = {"panel": "page", "serve": "server"}

__all__ = ["panel", "serve"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)
