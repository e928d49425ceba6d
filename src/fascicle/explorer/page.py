"""The page: a header with the muscle, its file and the units, and a tab for each view."""

import html
import io
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import panel as pn
from bokeh.models import CustomJS
from panel.io.resources import get_dist_path

from ..files import example, loads
from ..files.shipped_files import named_muscles, shipped_names
from ..io.sanitize import sanitize_line
from ..plot.theme import TITLE
from .bundle_tab import BundleView
from .compare_tab import CompareView
from .data_tab import RECORD_SUFFIXES, DataView
from .exports import EXPORTS, download_buttons, output_stem
from .link import to_query
from .measured import LARGEST_FILE
from .muscle_tab import MuscleView
from .state import CONTENT_FIELDS, DISPLAY_UNITS, TABS, Session, View, changed, view_of
from .story import Story
from .tab import Tab, session_document
from .theme import LAYOUT_CSS, WIDGET_CSS, column, page_colors, page_css, pane, row
from .time_tab import TimeView
from .widgets import Message, button, decode_upload, dropdown, file_input, widget


LARGEST_MUSCLE_FILE = 100_000  # bytes: a hundred tuned muscles
_QUIET = 400  # ms without a change until the address follows: browsers limit its changes
_CUSTOM = "(own)"
_PURPOSE = "Forces of fluidic artificial muscles, and where they buckle and collapse"
_SCRIPT, _FRAME = (
    Path(__file__).with_name(name).read_text(encoding="utf-8") for name in ("page.js", "frame.html")
)
_LOST = (
    "The connection to fascicle is lost: this page no longer updates. Run `fascicle explore` again"
    " and reload the page; its address holds the view."
)
# without the clipboard, which browsers give to this machine's pages and encrypted ones alone
_COPY = """
const text = location.href;
const copied = () => fascicleNotice("copied", "Link copied. It opens where fascicle explore runs at"
  + " this address: on another machine, start it there first.", true);
const show = () => prompt("Link", text);
navigator.clipboard ? navigator.clipboard.writeText(text).then(copied, show) : show();
"""
_VIEWS: Mapping[str, type[Tab]] = {
    "muscle": MuscleView,
    "bundle": BundleView,
    "compare": CompareView,
    "data": DataView,
    "time": TimeView,
}


class Header:
    """Example, file, units and theme; keeps the address up to date."""

    def __init__(
        self, session: Session, theme: str, theme_in_link: bool, show_theme: Callable[[str], None],
        open_record: Callable[[bytes, str], None],
    ):  # fmt: skip
        """Build it for a `session`; the address has the theme if it is dark or `theme_in_link`.

        `show_theme` shows the page in another theme, `open_record` a record in the tab Data.
        """
        self._open_record = open_record
        self._session, self._address_timer = session, None
        self._theme, self._show_theme = theme, show_theme
        self._theme_in_link = theme_in_link or theme == "dark"
        groups = {"Examples": shipped_names("examples"),
                  "Measured muscles": shipped_names("measured"), "Your own": [_CUSTOM]}  # fmt: skip
        self._example = widget(
            pn.widgets.Select, "Example", self._choose_example, groups=groups, width=200
        )
        self.file = file_input(
            "Open a file", f".toml,{RECORD_SUFFIXES}", self._open_file, width=216
        )
        self.save = widget(
            pn.widgets.FileDownload, "Save the file", filename="", width=110, margin=(22, 8, 4, 4),
            callback=lambda: io.BytesIO(session.view.text.encode()),
        )  # fmt: skip
        self._units = {
            kind: dropdown(kind.capitalize(), units, partial(self._set_unit, kind), width=86)
            for kind, units in DISPLAY_UNITS.items()
        }
        self._title = pane(margin=(8, 16, 4, 16), sizing_mode="stretch_width")
        style: dict[str, Any] = {"margin": (22, 4, 4, 4)}
        self.undo = button("Undo", session.undo, width=62, **style)
        self.reset = button("Reset", session.reset, width=62, **style)
        copy = button("Copy link", None, width=84, **style)
        copy.js_on_click(code=_COPY)
        self.theme_switch = button("", self._switch_theme, width=104, **style)
        self._name_theme_switch()
        inputs = row(self._example, self.file, self.save, *self._units.values(), self.undo,
                     self.reset, copy, self.theme_switch, kind="header", margin=(0, 8))  # fmt: skip
        self._offer = ""  # example that waits for an answer
        self._question = pane(margin=(6, 8))
        answers = (button("Replace it", self._replace), button("Keep it", self._keep))
        self.question = row(self._question, *answers, kind="wrapped", visible=False)
        self.message = Message()
        self.panel = column(self._title, inputs, self.question, self.message.pane)
        session.watch(self._follow)
        self._show(session.view)
        self._show_history()

    def _follow(self, before: View, after: View) -> None:
        if changed(before, after, "name", "display_units", "muscle", "units"):
            self._show(after)
        # a message on a link or a file is past, once something else is shown
        if changed(before, after, *CONTENT_FIELDS):
            self.message.show("")
            self.question.visible = False
        self._show_history()
        self._schedule_address()

    def _show_history(self) -> None:
        session = self._session
        self.undo.disabled = not session.can_undo
        self.reset.disabled = not changed(session.opened, session.view, *CONTENT_FIELDS)

    def _show(self, view: View) -> None:
        """Show name, example and units of a `view`."""
        self._title.object = (
            '<div style="display:flex;flex-wrap:wrap;align-items:baseline;gap:2px 14px">'
            f'<h1 style="font-size:{TITLE}px;line-height:1.2;margin:0">fascicle</h1>'
            f'<span style="color:var(--soft)">{_PURPOSE}</span><b style="margin-left:auto">'
            f"{html.escape(sanitize_line(view.name, 60), quote=True)}</b></div>"
        )
        if view.name in named_muscles():
            self.save.filename = f"{view.name}.toml"
        else:
            name, edited, _ = view.name.partition(", changed")
            kind = "changed" if edited else "copy"
            self.save.filename = f"{output_stem(name, kind, self._session.input_names)}.toml"
        self._example.value = view.name if view.name in named_muscles() else _CUSTOM
        for kind, select in self._units.items():
            select.value = view.display_units[kind]

    def _choose_example(self, chosen: str) -> None:
        if chosen in (_CUSTOM, self._session.view.name):  # set by the page itself
            return
        self.message.show("")
        self._offer = chosen
        if self._session.view.name in named_muscles():
            self._replace()
            return
        name = html.escape(sanitize_line(self._session.view.name, 60))
        self._question.object = f'<div role="alert">{chosen} would replace {name}.</div>'
        self.question.visible = True

    def _replace(self) -> None:
        """Open the example that was chosen."""
        self.question.visible = False
        name = self._offer
        self.file.clear()  # its name is another one's
        self._session.open(view_of(example(name), name, self._session.view))

    def _keep(self) -> None:
        """Keep the muscle that is open."""
        self.question.visible = False
        self._example.value = _CUSTOM

    def _open_file(self, raw: bytes, name: str) -> None:
        """Open a muscle, or in the tab Data a record, by the file's suffix."""
        with self.message.errors():
            if name.lower().endswith(tuple(RECORD_SUFFIXES.split(","))):
                self._open_record(raw, name)
                return
            text = decode_upload(raw, name, "muscle", LARGEST_MUSCLE_FILE)
            target = loads(text, source=name)
            self._session.input_names.add(name)
            self._session.open(view_of(target, name, self._session.view))

    def _set_unit(self, kind: str, unit: str) -> None:
        self._session.change(display_units={**self._session.view.display_units, kind: unit})

    def _switch_theme(self) -> None:
        self._theme = "default" if self._theme == "dark" else "dark"
        self._theme_in_link = True  # else the next visit would follow the system's preference
        self._show_theme(self._theme)
        self._name_theme_switch()
        self._schedule_address()

    def _name_theme_switch(self) -> None:
        self.theme_switch.label = f"Use {'light' if self._theme == 'dark' else 'dark'} page"

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
        query = to_query(self._session.view)
        if self._theme_in_link:
            query["theme"] = self._theme
        if pn.state.location is not None:
            pn.state.location.search = "?" + urlencode(query)


class Page:
    """The explorer of a visitor's session, as the Panel layout `panel`."""

    def __init__(
        self, session: Session, theme: str = "default", errors: Sequence[str] = (),
        theme_in_link: bool = False, offer: bool = False,
    ):  # fmt: skip
        """Page of a `session`; `errors` are of its link.

        With an `offer`, browsers that have not dismissed it offer the story.
        """
        self._session, self._colors = session, page_colors(theme)
        header = self.header = Header(
            session, theme, theme_in_link, self.show_theme, self.open_record
        )
        header.message.show(" ".join(errors))
        self._story = Story(session, offer)
        self._views: dict[str, Tab] = {}
        self._contents = {name: column() for name in TABS}
        self._tabs = pn.Tabs(
            *((name.capitalize(), content) for name, content in self._contents.items()),
            dynamic=True,
            stylesheets=[WIDGET_CSS, LAYOUT_CSS],
            css_classes=["narrow"],
            sizing_mode="stretch_width",
            margin=(0, 8),
            active=TABS.index(session.view.tab),
        )
        self._tabs.param.watch(lambda event: session.change(tab=TABS[event.new]), "active")
        session.watch(self._follow)
        self._open_tab(session.view.tab)
        self.panel = column(header.panel, self._story.panel, self._tabs, name="explorer")
        self._set_style()
        self.panel.jscallback(stylesheets="window.fascicleStyle?.(cb_obj.stylesheets.at(-1))")

    def open_record(self, raw: bytes, name: str) -> None:
        """Open a record's file in the tab Data."""
        self._session.change(tab="data")
        data = self._views["data"]
        assert isinstance(data, DataView)
        data.open_record(raw, name)

    def show_theme(self, theme: str) -> None:
        """Show the page in a `theme`, "default" or "dark"."""
        self._colors = page_colors(theme)
        self._set_style()
        for view in self._views.values():
            view.set_colors(self._colors)
        self._open_tab(self._session.view.tab)

    def _set_style(self) -> None:
        self.panel.stylesheets = [LAYOUT_CSS, page_css(self._colors)]

    def _open_tab(self, name: str) -> None:
        """Show a tab, which is made when it is first opened: most visitors never open most."""
        if name not in self._views:
            view = self._views[name] = _VIEWS[name](self._session, self._colors)
            self._contents[name].objects = [view.panel, *self._download_rows(name, view)]
        self._views[name].refresh()

    def _download_rows(self, name: str, view: Tab) -> list[Any]:
        """Download buttons of the tab with a `name`, in a row, and their message; empty for those
        with buttons of their own. The first tab's row also starts the story.
        """
        if name not in EXPORTS:
            return []
        session, story = self._session, []
        view.downloads = download_buttons(
            lambda: EXPORTS[name](session.view, session.input_names), view.download_message
        )
        if name == TABS[0]:
            story = [self._story.start_button("The story in four steps", margin=(2, 4))]
        buttons = row(*view.downloads, *story, kind="wrapped", sizing_mode=None, margin=(0, 8))
        return [buttons, view.download_message.pane]

    def _follow(self, before: View, after: View) -> None:
        if before.tab != after.tab:
            self._tabs.active = TABS.index(after.tab)
            self._open_tab(after.tab)


def prepare_document(doc: Any, active: str, follow_preference: bool) -> None:
    """Set a Bokeh document's frame, with the `active` tab, its script, and a notice if it is lost.

    With `follow_preference` the page is dark where the system's preference is.
    """
    doc.template = _FRAME
    doc.template_variables.update(
        purpose=_PURPOSE, tabs=TABS, active=active, title_size=TITLE,
        follow_preference=follow_preference,
        # Panel sets it later: until then its style sheets would come from another machine
        dist_url=get_dist_path(),
    )  # fmt: skip
    doc.js_on_event("document_ready", CustomJS(args={"largest": LARGEST_FILE}, code=_SCRIPT))
    for event, text in (("connection_lost", _LOST), ("client_reconnected", "")):
        notice = CustomJS(args={"text": text}, code="fascicleNotice('lost', text);")
        doc.js_on_event(event, notice)


def panel(target: str | Any = "kim2021_figure_6", theme: str = "default") -> Any:
    """The explorer as a Panel object, for a notebook's cell.

    **Arguments:**

    - `target`: a named example, a path, a `Muscle` or a `Bundle`.
    - `theme`: "default" or "dark".

    **Raises:** `ValueError` or `OSError` where there is no such muscle.
    """
    from ..files.muscle_files import load_muscle

    name = target if isinstance(target, str) else "muscle"
    opened: Any = target
    if isinstance(target, str):
        opened = example(target) if target in named_muscles() else load_muscle(target)
    pn.extension()
    return Page(Session(view_of(opened, name), pn.io.unlocked), theme).panel
