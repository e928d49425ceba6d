"""Inputs of a muscle: its sizes, material and laws; errors appear at their own fields."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import panel as pn

from ..core.errors import InvalidInputError
from ..core.module import replace_checked
from ..muscle.laws import LAWS
from ..muscle.materials import MATERIALS
from .state import CHANGED, Session, View, is_shipped
from .widgets import SIZES, Field, Message, column, dropdown, field_unit, fold


_CUSTOM = "its own"
_TITLES = {"post_collapse": "After collapse"}  # where it isn't the kind's name


class MuscleInputs:
    """Inputs of a muscle; a change makes another muscle, or shows why there is none."""

    def __init__(self, session: Session):
        self._session, self.message = session, Message()
        self.fields = {
            name: Field(label, name, dimension, partial(self._set_size, name))
            for name, (label, dimension) in SIZES.items()
        }
        self._material = dropdown("Material", [*MATERIALS, _CUSTOM], self._choose_material)
        self.laws = {kind: LawInputs(kind, self) for kind in LAWS}
        sizes = [widget for field in self.fields.values() for widget in field.widgets]
        panels = [law.panel for law in self.laws.values()]
        laws = fold("Advanced: laws and their constants", *panels)
        self.panel = column(column(*sizes, kind="pairs"), self._material, self.message.pane, laws)

    def show(self, view: View) -> None:
        """Show the muscle of a `view`."""
        muscle = view.muscle
        for name, (_, dimension) in SIZES.items():
            unit = field_unit(dimension, view.display_units)
            self.fields[name].show(float(getattr(muscle, name)), unit)
        names = [name for name, material in MATERIALS.items() if material == muscle.material]
        self._material.value = names[0] if names else _CUSTOM
        for kind, law in self.laws.items():
            law.show(getattr(muscle, kind), view.display_units)
        self.message.show("")

    def change(self, **parts: object) -> None:
        """Replace parts of the session's muscle, and rename it; `ValueError` if it can't be."""
        view, opened = self._session.view, self._session.opened
        muscle, name = view.muscle.replace(**parts), view.name.removesuffix(CHANGED)
        if muscle == opened.muscle:
            name = opened.name
        elif not is_shipped(name, muscle):
            name += CHANGED
        after = replace(view, muscle=muscle, name=name)
        _ = after.bundle  # raises at this field if it can't be a bundle any more
        self._session.show(after)

    def try_change(self, message: Message, **parts: object) -> None:
        """As `change`, with an error in a `message`."""
        with message.errors():
            self.change(**parts)

    def _set_size(self, name: str, value: float) -> None:
        try:
            self.change(**{name: value})
        except InvalidInputError as error:
            # a rule between two sizes names one of them: it is shown at both
            if error.argument != name and error.argument in self.fields:
                self.fields[error.argument].show_error(error)
            raise

    def _choose_material(self, name: str) -> None:
        if name != _CUSTOM and MATERIALS[name] != self._session.view.muscle.material:
            self.try_change(self.message, material=name)


class LawInputs:
    """Inputs of one kind of law: its name, and a field for each of its constants and options."""

    def __init__(self, kind: str, inputs: MuscleInputs):
        self._kind, self._inputs, self._message = kind, inputs, Message()
        self._law: Any = None
        self.fields: dict[str, Field] = {}
        self.choices: dict[str, pn.widgets.Select] = {}
        names = {name.replace("_", " "): name for name in LAWS[kind]}
        self.select = dropdown(_TITLES.get(kind, kind.capitalize()), names, self._choose_law)
        self._constants = column(margin=(0, 0, 0, 12))
        self.panel = column(self.select, self._message.pane, self._constants)

    def show(self, law: Any, units: Mapping[str, str]) -> None:
        """Show a `law` with quantities in `units`, by dimension."""
        before, self._law = self._law, law
        if type(law) is not type(before):
            self.fields, self.choices = {}, {}
            for name, dimension in ((x.name, x.dimension) for x in law.constants()):
                set_value = partial(self._set_constant, name)
                self.fields[name] = Field(_label_of(name), name, dimension, set_value)
            for switch in law.switches():
                options = {option.replace("_", " "): option for option in switch.options}
                choose = partial(self._choose_option, switch.name)
                self.choices[switch.name] = dropdown(_label_of(switch.name), options, choose)
            fields = [widget for field in self.fields.values() for widget in field.widgets]
            self._constants.objects = [*fields, *self.choices.values()]
        self.select.value = law.name
        for constant in law.constants():
            unit = field_unit(constant.dimension, units)
            self.fields[constant.name].show(float(getattr(law, constant.name)), unit)
        for name, choice in self.choices.items():
            choice.value = getattr(law, name)

    def _set_constant(self, name: str, value: object) -> None:
        self._inputs.change(**{self._kind: replace_checked(self._law, {name: value})})

    def _choose_law(self, name: str) -> None:
        if name != self._law.name:
            self._inputs.try_change(self._message, **{self._kind: name})

    def _choose_option(self, name: str, option: str) -> None:
        if option != getattr(self._law, name):
            law = replace_checked(self._law, {name: option})
            self._inputs.try_change(self._message, **{self._kind: law})


def _label_of(name: str) -> str:
    return name.replace("_", " ").capitalize()
