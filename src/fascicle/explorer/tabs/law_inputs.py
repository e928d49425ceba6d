"""A law of the muscle: which one, and a field for each number and choice of its own."""

from collections.abc import Callable, Mapping
from typing import Any

import panel as pn

from ...core.module import replace_checked
from ...muscle.law import AbstractLaw
from ...units import DIMENSIONS
from ..parts.look import Look
from ..parts.widgets import Field, choice


class LawInputs:
    """A kind of law; a change makes another law, which `takes` is given, or a refusal."""

    def __init__(
        self,
        look: Look,
        title: str,
        laws: Mapping[str, type[AbstractLaw]],
        takes: Callable[[Any], None],
        refused: Callable[[str], None],
    ):
        """**Arguments:**

        - `look`: the page's [-].
        - `title`: of the kind [-].
        - `laws`: of that kind, by name [-].
        - `takes`: the law that was chosen, by name, or with other numbers [-].
        - `refused`: is told why a choice can't be [-].
        """
        self._look, self._takes, self._refused = look, takes, refused
        self._law: Any = None
        self._silent = False
        self.fields: dict[str, Field] = {}
        self.choices: dict[str, Any] = {}
        self.select = choice(look, title, {name.replace("_", " "): name for name in laws})
        self.select.param.watch(lambda event: self._chose(event.new), "value")
        self._own = pn.Column(margin=(0, 0, 4, 12), sizing_mode="stretch_width")
        self.panel = pn.Column(self.select, self._own, margin=0, sizing_mode="stretch_width")

    def show(self, law: Any, units: Mapping[str, str]) -> None:
        """Show a `law` [-], its quantities in those `units` [-] that are shown."""
        self._silent = True
        if type(law) is not type(self._law):
            self._renew(law)
        self._law = law
        self.select.value = law.name
        for one in law.constants():
            unit = units.get(one.dimension, DIMENSIONS[one.dimension].shown)
            self.fields[one.name].show(float(getattr(law, one.name)), unit)
        for name, widget in self.choices.items():
            widget.value = getattr(law, name)
        self._silent = False

    def _renew(self, law: Any) -> None:
        self.fields = {
            one.name: Field(
                self._look, _title(one.name), one.name, one.dimension, self._set(one.name)
            )
            for one in law.constants()
        }
        self.choices = {
            one.name: choice(
                self._look, _title(one.name), {o.replace("_", " "): o for o in one.options}
            )
            for one in law.switches()
        }
        for name, widget in self.choices.items():
            widget.param.watch(lambda event, name=name: self._switched(name, event.new), "value")
        shown = [field.panel for field in self.fields.values()]
        self._own.objects = [*shown, *self.choices.values()]

    def _set(self, name: str) -> Callable[[float], None]:
        return lambda value: self._takes(replace_checked(self._law, {name: value}))

    def _switched(self, name: str, option: str) -> None:
        self._chose(replace_checked(self._law, {name: option}))

    def _chose(self, law: Any) -> None:
        if self._silent:
            return
        try:
            self._takes(law)
        except ValueError as error:
            self._refused(str(error))


def _title(name: str) -> str:
    return name.replace("_", " ").capitalize()
