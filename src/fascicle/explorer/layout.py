"""The page: a header with the muscle, its file and the units, and a tab for each view."""

from collections.abc import Callable, Sequence
from typing import Any

import panel as pn

from ..plot.theme import css
from .header import Header
from .parts.exports import EXPORTS, downloads
from .parts.look import NARROW, WRAPPED, Look, look_of, widget_css
from .state import TABS, Session, View
from .tabs.bundle import BundleView
from .tabs.data import DataView
from .tabs.efficiency import EfficiencyView
from .tabs.muscle import MuscleView
from .tabs.reversal import ReversalView


_TITLES = {"muscle": "Muscle", "bundle": "Bundle", "reversal": "Reversal",
           "efficiency": "Efficiency", "data": "Data"}  # fmt: skip
_VIEWS: dict[str, Callable[..., Any]] = {
    "muscle": MuscleView,
    "bundle": BundleView,
    "reversal": ReversalView,
    "efficiency": EfficiencyView,
    "data": DataView,
}


def build(
    session: Session, theme: str = "default", refused: Sequence[str] = (), asked: bool = False
) -> Any:
    """All of the explorer for one visitor.

    **Arguments:**

    - `session`: what is shown [-].
    - `theme`: "default" or "dark" [-].
    - `refused`: what the address asked for in vain, a line each [-].
    - `asked`: whether the address asks for the theme [-].

    **Returns:** a Panel layout [-].
    """
    look = look_of(theme)
    header = Header(session, look, asked)
    header.message.say(" ".join(refused))
    names = [name for name in TABS if name in _VIEWS]
    views: dict[str, Any] = {}
    narrow = {"sizing_mode": "stretch_width", "stylesheets": [NARROW]}
    places = {name: pn.Column(margin=0, **narrow) for name in names}
    tabs = pn.Tabs(
        *((_TITLES[name], places[name]) for name in names),
        dynamic=True,
        stylesheets=[widget_css(look), NARROW],
        sizing_mode="stretch_width",
        margin=(0, 8),
        active=names.index(session.view.tab) if session.view.tab in names else 0,
    )

    def look_at(name: str) -> None:
        # a tab is made when it is first looked at: most visitors never see most of them
        if name not in views:
            views[name] = _VIEWS[name](session, look)
            places[name].objects = [_with_downloads(session, look, name, views[name])]
        views[name].refresh()

    def switched(event: Any) -> None:
        name = names[event.new]
        if session.view.tab != name:
            session.change(tab=name)

    def follow(before: View, after: View) -> None:
        if before.tab != after.tab and after.tab in names:
            tabs.active = names.index(after.tab)
            look_at(after.tab)

    tabs.param.watch(switched, "active")
    session.watch(follow)
    look_at(names[tabs.active])
    # inherited by all that is in it, in a notebook too
    own = f":host {{ {css(look)} color: var(--ink); background: var(--paper); }}"
    return pn.Column(
        header.panel, tabs, name="explorer", margin=0, sizing_mode="stretch_width",
        stylesheets=[NARROW, own],
    )  # fmt: skip


def opening(look: Look) -> Any:
    """What stands there until the rest does [-], in a `look` [-]."""
    return pn.pane.HTML(
        f'<div role="status" style="padding:24px;color:{look.ink};font-size:15px">'
        "fascicle is drawing …</div>", margin=0,
    )  # fmt: skip


def _with_downloads(session: Session, look: Look, name: str, view: Any) -> Any:
    if name not in EXPORTS:  # the data's tab has its own: they need a record
        return view.panel
    buttons = downloads(look, name, lambda: EXPORTS[name](session.view))
    return pn.Column(
        view.panel,
        pn.Row(*buttons, margin=(0, 8), stylesheets=[WRAPPED]),
        sizing_mode="stretch_width",
        margin=0,
        stylesheets=[NARROW],
    )


def panel(target: str | Any = "kim2021_figure_6", theme: str = "default") -> Any:
    """The explorer as a Panel object, for a notebook's cell.

    **Arguments:**

    - `target`: a named example, a path, a `Muscle` or a `Bundle` [-].
    - `theme`: "default" or "dark" [-].

    **Returns:** the layout [-].

    **Raises:** `ValueError` or `OSError` where there is no such muscle.
    """
    from ..files import example, examples
    from ..files.reading import load
    from .state import view_of

    name = target if isinstance(target, str) else "muscle"
    found: Any = target
    if isinstance(target, str):
        found = example(target) if target in examples() else load(target)
    pn.extension()
    return build(Session(view_of(found, name), pn.io.unlocked), theme)
