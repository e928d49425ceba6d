"""Explorer: the same laws in a browser, or in a notebook.

Arrays of the laws (`…_curves`) are shown by widgets (`…_tab`); what a session shows is one
immutable `View`, which its address holds. The command line's help loads no Panel.
"""

from typing import TYPE_CHECKING

from ..core.lazy import attach_lazy


if TYPE_CHECKING:
    from .page import panel as panel
    from .server import serve as serve

__all__ = ["panel", "serve"]

__getattr__, __dir__ = attach_lazy(__name__, {"panel": "page", "serve": "server"})
