"""The page: a header with the muscle, its file and the units, and a tab for each view."""

import html
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import panel as pn
from bokeh.models import CustomJS
from panel.io.resources import get_dist_path

from ..bundle import Bundle
from ..files import descriptions, example, loads, named_muscles
from ..io.sanitize import sanitize_line
from ..muscle import Muscle
from ..plot.theme import TITLE
from . import widgets as ui
from .bundle_tab import BundleView
from .compare_tab import CompareView
from .data_tab import LARGEST_FILE, RECORD_SUFFIXES, DataView
from .link import to_query
from .muscle_tab import MuscleView
from .state import CHANGED, CONTENT_FIELDS, DISPLAY_UNITS, TABS, Session, View, changed, view_of
from .story import Story
from .tab import Tab, output_stem, session_document
from .texts import TEXTS
from .time_tab import TimeView


LARGEST_MUSCLE_FILE = 100_000  # bytes: a hundred tuned muscles
_QUIET = 400  # ms without a change until the address follows: browsers limit its changes
_CUSTOM = "(own)"
_SCRIPT, _FRAME = (
    Path(__file__).with_name(name).read_text(encoding="utf-8") for name in ("page.js", "frame.html")
)
_VIEWS: Mapping[str, type[Tab]] = {
    view.name: view for view in (MuscleView, BundleView, CompareView, DataView, TimeView)
}
_FILES = {"svg": "Picture", "png": "Picture", "pdf": "Picture", "csv": "Data"}
_FOLD: Any = {"kind": "wrapped", "margin": (22, 4, 4, 4), "width": 86}
_THEMES = {"default": "light", "dark": "dark"}
_GROUPS = {"Examples": "examples", "Measured muscles": "measured"}  # of shipped muscles


class Header:
    """Example, file, history, sharing, units and theme; keeps the address up to date."""

    def __init__(self, page: "Page", theme: str):
        """Header of a `page` in a `theme`, "" where the address has none."""
        session = self._session = page.session
        self._page, self._theme, self._address_timer = page, theme, None
        self.message = ui.Message()
        groups = {
            title: {
                text.partition(", from ")[0].replace("`", "")[:60]: name
                for name, text in descriptions(kind).items()
            }
            for title, kind in _GROUPS.items()
        }
        groups["Your own"] = {_CUSTOM: _CUSTOM}
        self._example = ui.widget(
            pn.widgets.Select, "Example", self._choose_example, groups=groups, width=250
        )
        suffixes = f".toml,{RECORD_SUFFIXES}"
        self.file = ui.file_input("Open a file", suffixes, self._open_file, width=216)
        style = {"margin": (22, 4, 4, 4)}
        self.undo = ui.button("Undo", session.undo, css_classes=["undo"], width=62, **style)
        self.redo = ui.button("Redo", session.redo, css_classes=["redo"], width=62, **style)
        self.reset = ui.button("Reset", session.reset, width=62, **style)
        save = partial(ui.download_button, message=self.message)
        copy = ui.button("Copy link", None, margin=(2, 4), width=150)
        copy.js_on_click(code="fascicleCopy()")
        files = (
            save(f"{kind} ({suffix.upper()})", partial(self._tab_file, suffix))
            for suffix, kind in _FILES.items()
        )
        page_file = save("Web page (HTML)", self._web_page)
        view_file = save("Muscle or bundle (TOML)", self._file, width=190)
        share, shared = ui.fold("Share ▾", view_file, page_file, copy, *files, **_FOLD)
        self._units = {
            kind: ui.dropdown(kind.capitalize(), units, partial(self._set_unit, kind), width=86)
            for kind, units in DISPLAY_UNITS.items()
        }
        other = "default" if theme == "dark" else "dark"
        switch = ui.button(f"Use {_THEMES[other]} page", None, width=120, **style)
        switch.js_on_click(code=f"fascicleTheme('{other}')")
        units, chosen = ui.fold("Units ▾", *self._units.values(), switch, **_FOLD)
        self._title = ui.wide_pane(margin=(8, 16, 4, 16))
        history = (self.undo, self.redo, self.reset)
        inputs = ui.row(self._example, self.file, *history, share, units, kind="header")
        self.panel = ui.column(self._title, inputs, shared, chosen, self.message.pane)
        session.watch(self._follow)
        self._show(session.view)

    def _follow(self, before: View, after: View) -> None:
        # a message on a link or a file is past, once something else is shown
        if changed(before, after, *CONTENT_FIELDS):
            self.message.show("")
        self._show(after)
        self._schedule_address()

    def _show(self, view: View) -> None:
        name = html.escape(sanitize_line(view.name, 60), quote=True)
        self._title.object = (
            f'<div class="title"><h1 style="font-size:{TITLE}px">fascicle</h1>'
            f"<span>{TEXTS['page']['purpose']}</span><b>{name}</b></div>"
        )
        self._example.value = view.name if view.name in named_muscles() else _CUSTOM
        for kind, select in self._units.items():
            select.value = view.display_units[kind]
        self.undo.disabled, self.redo.disabled = (not number for number in self._session.changes)
        self.reset.disabled = not changed(self._session.opened, view, *CONTENT_FIELDS)

    def _choose_example(self, name: str) -> None:
        if name in (_CUSTOM, self._session.view.name):  # set by the page itself
            return
        self.file.clear()  # its name is another one's
        self._session.open(view_of(example(name), name, self._session.view))

    def _open_file(self, raw: bytes, name: str) -> None:
        """Open a muscle, or in the tab Data a record, by the file's suffix."""
        with self.message.errors():
            if name.lower().endswith(tuple(RECORD_SUFFIXES.split(","))):
                self._page.open_record(raw, name)
                return
            target = loads(ui.decode_upload(raw, name, LARGEST_MUSCLE_FILE), source=name)
            self._session.open(view_of(target, name, self._session.view))

    def _set_unit(self, kind: str, unit: str) -> None:
        self._session.change(display_units={**self._session.view.display_units, kind: unit})

    def _file(self) -> tuple[str, bytes]:
        view = self._session.view
        kind = "changed" if view.name.endswith(CHANGED) else "copy"
        return f"{output_stem(view.name.removesuffix(CHANGED), kind)}.toml", view.text.encode()

    def _web_page(self) -> tuple[str, bytes]:
        from ..export import page_text  # with it comes JAX

        view = self._session.view
        text = page_text(view.muscle if view.tab == "muscle" else view.bundle, view.name)
        return f"{output_stem(view.name.removesuffix(CHANGED), 'page')}.html", text.encode()

    def _tab_file(self, suffix: str) -> tuple[str, bytes]:
        export = self._page.open_view.export()
        return f"{export.stem}.{suffix}", export.content(suffix)

    def _schedule_address(self) -> None:
        """Change the address once nothing has changed for a while."""
        doc = session_document()
        if doc is None or pn.state.location is None:
            return
        if self._address_timer is not None:
            doc.remove_timeout_callback(self._address_timer)
        self._address_timer = doc.add_timeout_callback(self._set_address, _QUIET)

    def _set_address(self) -> None:
        self._address_timer = None
        query = to_query(self._session.view) | ({"theme": self._theme} if self._theme else {})
        if pn.state.location is not None:
            pn.state.location.search = "?" + urlencode(query)


class Page:
    """The explorer of a visitor's session, as the Panel layout `panel`."""

    def __init__(
        self,
        session: Session,
        theme: str = "",
        errors: Sequence[str] = (),
        offer: bool = False,
    ):
        """Page of a `session`; `errors` of its link; with an `offer` of the story."""
        self.session, self._colors = session, ui.page_colors(theme)
        self.header = Header(self, theme)
        self.header.message.show(" ".join(errors))
        self._story = Story(session, offer)
        self._views: dict[str, Tab] = {}
        self._contents = {name: ui.column() for name in TABS}
        self._tabs = pn.Tabs(
            *((name.capitalize(), content) for name, content in self._contents.items()),
            dynamic=True,
            stylesheets=[ui.WIDGET_CSS, ui.LAYOUT_CSS],
            css_classes=["narrow"],
            sizing_mode="stretch_width",
            margin=(0, 8),
            active=TABS.index(session.view.tab),
        )
        self._tabs.param.watch(lambda event: session.change(tab=TABS[event.new]), "active")
        session.watch(self._follow)
        self._open_tab(session.view.tab)
        parts = self.header.panel, self._story.panel, self._tabs
        style = [ui.LAYOUT_CSS, ui.page_css(self._colors)]
        self.panel = ui.column(*parts, name="explorer", stylesheets=style)

    @property
    def open_view(self) -> Tab:
        return self._views[self.session.view.tab]

    def open_record(self, raw: bytes, name: str) -> None:
        self.session.change(tab="data")
        view = self.open_view
        assert isinstance(view, DataView)
        view.open_record(raw, name)

    def _open_tab(self, name: str) -> None:
        """Show a tab, which is made when it is first opened: most visitors never open most."""
        if name not in self._views:
            view = self._views[name] = _VIEWS[name](self.session, self._colors)
            parts: list[Any] = [view.panel]
            if name == TABS[0]:
                parts.append(self._story.start_button("The story in four steps", margin=(2, 8)))
            self._contents[name].objects = parts
        self._views[name].refresh()

    def _follow(self, before: View, after: View) -> None:
        if before.tab != after.tab:
            self._tabs.active = TABS.index(after.tab)
            self._open_tab(after.tab)


def prepare_document(doc: Any, active: str, follow_preference: bool) -> None:
    """Set a Bokeh document's frame, with the `active` tab, its script, and a notice if it is lost;
    with `follow_preference` it is dark where the system's preference is.
    """
    doc.template = _FRAME
    doc.template_variables.update(
        purpose=TEXTS["page"]["purpose"],
        tabs=TABS,
        active=active,
        title_size=TITLE,
        follow_preference=follow_preference,
        # Panel sets it later: until then its style sheets would come from another machine
        dist_url=get_dist_path(),
    )
    doc.js_on_event("document_ready", CustomJS(args={"largest": LARGEST_FILE}, code=_SCRIPT))
    for event, text in (("connection_lost", TEXTS["page"]["lost"]), ("client_reconnected", "")):
        notice = CustomJS(args={"text": text}, code="fascicleNotice('lost', text);")
        doc.js_on_event(event, notice)


def panel(target: str | Muscle | Bundle = "kim2021_figure_6", theme: str = "default") -> pn.Column:
    """The explorer as a Panel object, for a notebook's cell.

    `target`: a named example, a path, a `Muscle` or a `Bundle`; `theme`: "default" or "dark".
    `ValueError` or `OSError` where there is no such muscle.
    """
    from ..files.muscle_files import load_muscle

    name, opened = target if isinstance(target, str) else "muscle", target
    if isinstance(opened, str):
        opened = example(opened) if opened in named_muscles() else load_muscle(opened)
    pn.extension()
    return Page(Session(view_of(opened, name), batch=pn.io.unlocked), theme).panel
