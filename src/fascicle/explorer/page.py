"""The page: a header with the muscle, its file and the units, and a tab for each view."""

import time
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any
from urllib.parse import urlencode

import panel as pn

from ..files import example, examples, loads
from ..io.sanitize import sanitize_line
from ..plot.theme import TITLE, css
from .bundle_tab import BundleView
from .data_tab import DataView
from .efficiency_tab import EfficiencyView
from .exports import EXPORTS, downloads, output_stem
from .link import to_query
from .muscle_tab import MuscleView
from .reversal_tab import ReversalView
from .state import SHOWN, TABS, Session, View, changed, view_of
from .theme import HEADED, NARROW, WRAPPED, Look, look_of, widget_css
from .widgets import Message, button, choice


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
    from ..files.muscle_files import load_muscle
    from .state import view_of

    name = target if isinstance(target, str) else "muscle"
    found: Any = target
    if isinstance(target, str):
        found = example(target) if target in examples() else load_muscle(target)
    pn.extension()
    return build(Session(view_of(found, name), pn.io.unlocked), theme)


LARGEST_FILE = 100_000  # bytes of a muscle file
_QUIET = 400  # ms without a change until the address follows: browsers ration its changes
_KEPT = ("shown", "tab")  # a look at the same muscle: what was said of it stands
_OTHER = "(own)"
_PURPOSE = "What fluidic muscles of given sizes pull, and where they buckle and fold."
_OTHER_THEME = """
const there = new URL(location);
there.searchParams.set("theme", "%s");
location.assign(there);
"""


class Header:
    """Example, file, units and theme; keeps the address up to date."""

    def __init__(self, session: Session, look: Look, asked: bool = False):
        """**Arguments:** `session` [-]; `look`: the page's [-]; `asked`: whether the address asks
        for it [-].
        """
        self._asked = asked
        self._session, self._look, self._silent = session, look, False
        self._pending: Any = None
        self._touched = 0.0  # when something changed last
        css = [widget_css(look)]
        self._example = choice(look, "Example", [*examples(), _OTHER], width=230, sizing_mode=None)
        self._example.param.watch(self._choose, "value")
        self._file = pn.widgets.FileInput(
            label="Open a file", accept=".toml", stylesheets=css, width=256, margin=(2, 8)
        )
        # an empty file changes nothing but the name
        self._file.param.watch(self._open, ["value", "filename"])
        self._save = pn.widgets.FileDownload(
            label="Save the file", callback=self._text, filename=_file_name(session.view),
            stylesheets=css, width=130, margin=(22, 8, 4, 4),
        )  # fmt: skip
        self._units = {
            kind: choice(look, kind.capitalize(), units, width=86, sizing_mode=None)
            for kind, units in SHOWN.items()
        }
        for kind, widget in self._units.items():
            widget.param.watch(self._showing(kind), "value")
        self._name = pn.pane.HTML("", margin=(8, 16, 4, 16), sizing_mode="stretch_width")
        self._theme = button(
            look, "Light page" if look.dark else "Dark page", lambda: None, width=100,
            margin=(22, 8, 4, 4),
        )  # fmt: skip
        self._theme.js_on_click(code=_OTHER_THEME % ("default" if look.dark else "dark"))
        self.message = Message("file")
        row = pn.Row(
            self._example, self._file, self._save, *self._units.values(), self._theme,
            sizing_mode="stretch_width", margin=(0, 8), stylesheets=[HEADED],
        )  # fmt: skip
        self.panel = pn.Column(
            self._name,
            row,
            self.message.pane,
            margin=0,
            sizing_mode="stretch_width",
            stylesheets=[NARROW],
        )
        session.watch(self._changed)
        self._show(session.view)

    def _changed(self, before: View, after: View) -> None:
        if changed(before, after, "name", "shown", "muscle", "units"):
            self._show(after)
        # what a link or a file asked for in vain is past, once something else is shown
        if changed(before, after, *(one.name for one in fields(View) if one.name not in _KEPT)):
            self.message.say("")
        self._later()

    def _show(self, view: View) -> None:
        self._silent = True
        self._name.object = (
            '<div style="display:flex;flex-wrap:wrap;align-items:baseline;gap:2px 14px">'
            f'<h1 style="font-size:{TITLE}px;line-height:1.2;margin:0">fascicle</h1>'
            f'<span style="color:var(--soft)">{_PURPOSE}</span>'
            f'<b style="margin-left:auto">{_safe(sanitize_line(view.name, 60))}</b></div>'
        )
        self._save.filename = _file_name(view)
        self._example.value = view.name if view.name in examples() else _OTHER
        for kind, widget in self._units.items():
            widget.value = view.shown[kind]
        self._silent = False

    def _choose(self, event: Any) -> None:
        if self._silent or event.new == _OTHER:
            return
        self.message.say("")
        self._session.become(view_of(example(event.new), event.new, self._session.view))

    def _open(self, *_: Any) -> None:
        raw = self._file.value or b""
        name = str(self._file.filename or "file")[-60:]
        try:
            if not raw:
                raise ValueError(f"{name}: the file is empty, 0 bytes.")
            if len(raw) > LARGEST_FILE:
                raise ValueError(
                    f"{name}: a muscle file may have {LARGEST_FILE} bytes, got {len(raw)}."
                )
            found = loads(_decoded(raw, name), source=name)
            self._session.become(view_of(found, name, self._session.view))
            self.message.say("")
        except ValueError as error:
            self.message.say(str(error))

    def _text(self) -> Any:
        import io

        return io.BytesIO(self._session.view.text.encode())

    def _showing(self, kind: str) -> Any:
        def take(event: Any) -> None:
            if not self._silent:
                self._session.change(shown={**self._session.view.shown, kind: event.new})

        return take

    def _later(self) -> None:
        """Change the address once nothing has changed for a while."""
        doc = pn.state.curdoc
        if doc is None or not doc.session_context or pn.state.location is None:
            return
        self._touched = time.monotonic()
        if self._pending is None:
            self._pending = doc.add_timeout_callback(self._follow, _QUIET)

    def _follow(self) -> None:
        doc, quiet = pn.state.curdoc, 1e3 * (time.monotonic() - self._touched)
        if doc is not None and quiet < 0.9 * _QUIET:  # moved since: later
            self._pending = doc.add_timeout_callback(self._follow, int(_QUIET - quiet))
            return
        self._pending = None
        view = self._session.view
        query = to_query(view)
        if self._look.dark or self._asked:
            query["theme"] = "dark" if self._look.dark else "default"
        if pn.state.location is not None:
            pn.state.location.search = "?" + urlencode(query)


def _file_name(view: View) -> str:
    """Name of the file that a `view` is saved in [-]: not the one that it was opened from."""
    if view.name in examples():
        return f"{view.name}.toml"
    name, changes, _ = view.name.partition(", changed")
    # without a suffix, nothing of a name is one
    stem = output_stem(name if name.endswith(".toml") else f"{name}.toml",
                       "changed" if changes else "copy")  # fmt: skip
    return f"{stem}.toml"


def _decoded(raw: bytes, name: str) -> str:
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        raise ValueError(f"{name}: not a text file in UTF-8.") from None


def _safe(text: str) -> str:
    import html

    return html.escape(text, quote=True)
