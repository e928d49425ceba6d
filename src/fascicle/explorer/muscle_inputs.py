"""Inputs of a muscle: its sizes, material and laws; errors appear at their own fields."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import panel as pn

from ..core.errors import InvalidInputError
from ..core.module import replace_checked
from ..muscle.law import AbstractLaw
from ..muscle.laws import LAWS
from ..muscle.materials import MATERIALS
from ..units import DIMENSIONS
from .state import Session, View
from .theme import PAIRS, WHOLE_ROW
from .widgets import Field, Message, dropdown


SIZES = {
    "length": ("Length at rest", "length"),
    "outer_radius": ("Bladder radius", "length"),
    "wall_thickness": ("Wall thickness", "length"),
    "braid_angle": ("Braid angle", "angle"),
}
_CUSTOM = "its own"
_TITLES = {"post_collapse": "After collapse"}  # where it isn't the kind's name
_INDENT: dict[str, Any] = {"styles": WHOLE_ROW, "margin": (2, 8, 2, 20)}


class LawInputs:
    """Inputs of one kind of law: its name, and a field for each of its constants and options."""

    def __init__(
        self,
        title: str,
        laws: Mapping[str, type[AbstractLaw]],
        set_law: Callable[[Any], None],
        refuse: Callable[[ValueError], None],
        arrange: Callable[[], None],
    ):
        """**Arguments:**

        - `title`: of the kind.
        - `laws`: of that kind, by name.
        - `set_law`: takes a law, or the name of one.
        - `refuse`: takes the error of an option that can't be.
        - `arrange`: is called when another law brings other fields.
        """
        self._set_law, self._refuse, self._arrange = set_law, refuse, arrange
        self._law: Any = None
        self._updating = False
        self.fields: dict[str, Field] = {}
        self.choices: dict[str, Any] = {}
        names = {name.replace("_", " "): name for name in laws}
        self.select = dropdown(title, names, styles=WHOLE_ROW)
        self.select.param.watch(lambda event: self._choose(event.new), "value")

    @property
    def widgets(self) -> list[Any]:
        """Widgets in the order of the page."""
        fields = [field.input for field in self.fields.values()]
        return [self.select, *fields, *self.choices.values()]

    def show(self, law: Any, units: Mapping[str, str]) -> None:
        """Show a `law` with quantities in `units`, by dimension."""
        self._updating = True
        if type(law) is not type(self._law):
            self._renew(law)
        self._law = law
        self.select.value = law.name
        for constant in law.constants():
            unit = units.get(constant.dimension, DIMENSIONS[constant.dimension].shown)
            self.fields[constant.name].show(float(getattr(law, constant.name)), unit)
        for name, widget in self.choices.items():
            widget.value = getattr(law, name)
        self._updating = False

    def _renew(self, law: Any) -> None:
        self.fields = {
            constant.name: Field(
                _title(constant.name), constant.name, constant.dimension,
                self._setter(constant.name), **_INDENT,
            )
            for constant in law.constants()
        }  # fmt: skip
        self.choices = {
            switch.name: dropdown(
                _title(switch.name), {o.replace("_", " "): o for o in switch.options}, **_INDENT
            )
            for switch in law.switches()
        }
        for name, widget in self.choices.items():
            widget.param.watch(lambda event, name=name: self._switch(name, event.new), "value")
        self._arrange()

    def _setter(self, name: str) -> Callable[[float], None]:
        return lambda value: self._set_law(replace_checked(self._law, {name: value}))

    def _switch(self, name: str, option: str) -> None:
        if not self._updating:
            self._choose(replace_checked(self._law, {name: option}))

    def _choose(self, law: Any) -> None:
        if self._updating:
            return
        try:
            self._set_law(law)
        except ValueError as error:
            self._refuse(error)


class MuscleInputs:
    """Inputs of a muscle; a change makes another muscle, or shows why there is none."""

    def __init__(self, session: Session):
        """**Arguments:** `session`: the visitor's."""
        self._session, self._updating = session, False
        self.fields = {
            name: Field(label, name, dimension, self._size_setter(name))
            for name, (label, dimension) in SIZES.items()
        }
        self._material = dropdown("Material", [*MATERIALS, _CUSTOM], styles=WHOLE_ROW)
        self._material.param.watch(self._choose_material, "value")
        self.laws = {
            kind: LawInputs(
                _TITLES.get(kind, kind.capitalize()), known, self._law_setter(kind), self.refuse,
                self._arrange,
            )
            for kind, known in LAWS.items()
        }  # fmt: skip
        self.panel = pn.Column(sizing_mode="stretch_width", margin=0, stylesheets=[PAIRS])
        self.message = Message(self.panel)
        for field in self.fields.values():
            field.place(self.panel)
        self._arrange()

    def refuse(self, error: ValueError | str) -> None:
        """Show an error of none of the fields below all of them."""
        self.message.show(error, self._session.view.shown)

    def show(self, view: View) -> None:
        """Show the muscle of a `view`."""
        self._updating = True
        muscle = view.muscle
        for name, field in self.fields.items():
            length = SIZES[name][1] == "length"
            field.show(float(getattr(muscle, name)), view.shown["length"] if length else "deg")
        known = [name for name, material in MATERIALS.items() if material == muscle.material]
        self._material.value = known[0] if known else _CUSTOM
        for kind, law in self.laws.items():
            law.show(getattr(muscle, kind), view.shown)
        self.message.show("")
        self._updating = False

    def _arrange(self) -> None:
        sizes = [field.input for field in self.fields.values()]
        laws = [widget for law in self.laws.values() for widget in law.widgets]
        self.panel.objects = [*sizes, self._material, *laws]
        for law in self.laws.values():
            for field in law.fields.values():
                field.place(self.panel)

    def _size_setter(self, name: str) -> Callable[[float], None]:
        def set_size(value: float) -> None:
            try:
                self._change(**{name: value})
            except InvalidInputError as error:
                # a rule between two sizes names one of them: it is shown at both
                if error.argument != name and error.argument in self.fields:
                    self.fields[error.argument].refuse(error)
                raise

        return set_size

    def _choose_material(self, event: Any) -> None:
        if self._updating or event.new == _CUSTOM:
            return
        try:
            self._change(material=event.new)
        except ValueError as error:
            self.refuse(error)

    def _law_setter(self, kind: str) -> Callable[[Any], None]:
        return lambda law: self._change(**{kind: law})

    def _change(self, **parts: Any) -> None:
        view = self._session.view
        name = view.name if view.name.endswith(", changed") else f"{view.name}, changed"
        after = replace(view, muscle=view.muscle.replace(**parts), name=name)
        _ = after.bundle  # raises here, where it was typed, if it can't be a bundle any more
        self._session.show(after)


def _title(name: str) -> str:
    return name.replace("_", " ").capitalize()
