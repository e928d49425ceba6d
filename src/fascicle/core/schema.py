"""Schemas of files: pydantic models whose fields carry units, and one-line errors from them.

```python
class Section(TableModel):
    length: Annotated[float, Quantity("length")]
```

Pydantic reports every fault of a file at once. One is enough to act on, so the most telling one
is shown: an unknown key before the missing one that it probably misspells.
"""

import difflib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, GetCoreSchemaHandler, ValidationError

from ..units import parse


# marks of a value that is either plain or a table in pydantic's paths: no key of a file
PLAIN, TABLE = "\0plain", "\0table"
_ORDER = ("extra_forbidden", "missing")  # the most telling faults first
_RULES = {
    "model_type": "must be a table of keys",
    "dict_type": "must be a table of keys",
    "list_type": "must be a list",
    "string_type": "must be a name in quotes",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
}


class TableModel(BaseModel):
    """A table of a file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @classmethod
    def known_keys(cls, table: Any) -> list[str]:
        """Keys to suggest for an unknown one in a `table` of this kind."""
        del table
        return list(cls.model_fields)


@dataclass(frozen=True)
class Quantity:
    """Annotation of a field that is text with a unit in the file, and a float [SI] here.

    - `dimension`: a key of `fascicle.units.DIMENSIONS`.
    - `many`: true to accept a list of quantities, too, as an array.
    """

    dimension: str
    many: bool = False

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> Any:
        """Let pydantic parse the text before it checks the type."""
        return BeforeValidator(self._parse).__get_pydantic_core_schema__(source, handler)

    def _parse(self, value: Any, info: Any) -> Any:
        if self.many and isinstance(value, list) and value:
            return np.array([parse(x, self.dimension, info.field_name) for x in value])
        return parse(value, self.dimension, info.field_name)


def plain_or_table(value: Any) -> str:
    """Discriminator of fields that are a name, a number or a table."""
    return TABLE if isinstance(value, dict) else PLAIN


def validation_message(
    error: ValidationError, source: str, data: Any, model: type[BaseModel]
) -> str:
    """One line for the most telling fault of a file: path, key, value and rule.

    **Arguments:**

    - `error`: pydantic's.
    - `source`: the file's name.
    - `data`: its tables.
    - `model`: the model that they should fit.

    **Returns:** the line.
    """
    faults = sorted(
        error.errors(include_url=False),
        key=lambda fault: _ORDER.index(fault["type"]) if fault["type"] in _ORDER else len(_ORDER),
    )
    fault, more = faults[0], len(faults) - 1
    kind = fault["type"]
    path = [part for part in fault["loc"] if part not in (PLAIN, TABLE)]
    # a lone muscle's name is empty
    keys = [part for i, part in enumerate(path) if part != "" or i != 1 or path[0] != "muscle"]
    if kind == "extra_forbidden":
        section = _section(model, fault["loc"][:-1])
        hint = did_you_mean(str(keys[-1]), section.known_keys(value_at(data, path[:-1])))
        return location_message(source, keys, f"unknown key{hint}")
    if kind == "missing":
        examples = getattr(_field(model, fault["loc"]), "examples", None) or [""]
        example = examples[0] if examples[0][:1] == "[" else f"{keys[-1]} = {examples[0]}"
        remedy = f", write {example}" if examples[0] else ""
        return location_message(source, keys, f"missing{remedy}.")
    rule = str(fault.get("ctx", {}).get("error") or _RULES.get(kind, fault["msg"]))
    others = f" ({more} more after it)" if more else ""
    return location_message(source, keys, f"{rule.rstrip('.')}.{others}", value_at(data, path))


def location_message(source: str, keys: Iterable[Any], rule: str, value: Any = None) -> str:
    """`source: dotted.key = value: rule`, on one line; a table or `None` isn't shown as value."""
    key = re.sub(r"\.(\d+)", lambda index: f"[{index[1]}]", ".".join(map(_toml_key, keys)))
    shown = ""
    if isinstance(value, str | int | float | bool):
        text = json.dumps(value, ensure_ascii=False)
        shown = f" = {text if len(text) <= 60 else text[:50] + '…'}"
    return " ".join(f"{source}: {key}{shown}: {rule}".split())


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The end of a sentence: `, did you mean "length"?` if a name is similar, else the choices."""
    choices = sorted(known)
    near = difflib.get_close_matches(name, choices, n=1, cutoff=0.6)
    if near:
        return f', did you mean "{near[0]}"?'
    return f", choose one of {', '.join(choices)}." if choices else "."


def value_at(data: Any, keys: Iterable[Any]) -> Any:
    """The value in nested tables and lists at `keys`, or `None`."""
    for key in keys:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _toml_key(part: Any) -> str:
    """A key as TOML writes it: in quotes where it isn't a bare one."""
    text = str(part)
    if isinstance(part, int) or re.fullmatch(r"[\w-]{1,40}", text, re.ASCII):
        return text
    quoted = json.dumps(text, ensure_ascii=False)
    return quoted if len(quoted) <= 42 else quoted[:40] + "…"


def _field(model: type[BaseModel], loc: Sequence[Any]) -> Any:
    """The model's field at a path; names and indices that aren't fields are passed over."""
    field = None
    for part in loc:
        fields: Mapping[Any, Any] = model.model_fields
        if part in fields:
            field = fields[part]
            model = next(iter(_models(field.annotation)), model)
    return field


def _section(model: Any, loc: Sequence[Any]) -> Any:
    field = _field(model, loc)
    return next(iter(_models(getattr(field, "annotation", None))), model)


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Models in an annotation such as `list[MotorUnitSection] | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    arguments = getattr(annotation, "__args__", ())
    return [model for argument in arguments for model in _models(argument)]
