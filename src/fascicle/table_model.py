"""Schemas of files: pydantic models whose fields carry units, and one-line errors from them.

```python
class Section(TableModel):
    length: Annotated[float, Quantity("length")]
```

Pydantic reports every fault of a file at once. The first error shows one of them: an unknown key
before the missing one that it probably misspells.
"""

import difflib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias, TypeVar

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    GetCoreSchemaHandler,
    Tag,
    ValidationError,
)

from .units import parse


_Model = TypeVar("_Model", bound=BaseModel)
_Plain = TypeVar("_Plain")
_Table = TypeVar("_Table")

# marks in pydantic's paths of a value that is either plain or a table: no key of a file
_PLAIN, _TABLE = "\0plain", "\0table"
_ORDER = {"extra_forbidden": 0, "missing": 1}  # faults that are shown first: they cause others
_PLAIN_WORDS = {  # for pydantic's
    "Input should be": "must be",
    "greater than or equal to": "at least",
    "less than or equal to": "at most",
}
# messages of pydantic's kinds of faults
_RULES = {
    "model_type": "must be a table of keys",
    "dict_type": "must be a table of keys",
    "list_type": "must be a list",
    "string_type": "must be a name in quotes",
    "bool_type": "must be true or false",
    "greater_than": "must be positive",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
}


class TableModel(BaseModel):
    """A table of a file; unknown keys are refused."""

    # built at its first use: a command reads one kind of file
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


@dataclass(frozen=True)
class Quantity:
    """Annotation of a field that is text with a unit in the file, of a `dimension` of
    `fascicle.units`, and a float [SI] here; if `many`, also a list of them, an array.
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


# a plain value, or a table or a list of them: the choice is by type, so an error names one key
PlainOrTable: TypeAlias = Annotated[
    Annotated[_Plain, Tag(_PLAIN)] | Annotated[_Table, Tag(_TABLE)],
    Discriminator(lambda value: _TABLE if isinstance(value, dict | list | BaseModel) else _PLAIN),
]


class FileError(ValueError):
    """A value in a file that breaks a rule: one line for people, fields for programs.

    - `source`: the file's name; `argument`: the dotted keys of the value, such as "muscle.length"
      or "schedule[2].time".
    - `rule`: broken rule, in words; `value`: the value, or `None`.
    """

    def __init__(self, source: str, keys: Iterable[Any], rule: str, value: Any = None):
        self.source, self.keys, self.rule, self.value = source, tuple(keys), rule, value
        path = ".".join(map(_toml_key, self.keys))
        self.argument = re.sub(r"\.(\d+)", lambda index: f"[{index[1]}]", path)
        value_text = ""
        if isinstance(value, str | int | float | bool):
            text = json.dumps(value, ensure_ascii=False)
            value_text = f" = {text if len(text) <= 60 else text[:50] + '…'}"
        line = " ".join(f"{source}: {self.argument}{value_text}: {rule}".split())
        # halves of characters can't be shown
        super().__init__(line.encode("utf-8", "backslashreplace").decode())

    def __reduce__(self) -> tuple[Any, ...]:
        # the error of a worker process arrives with its fields
        return type(self), (self.source, self.keys, self.rule, self.value)


def validate(model: type[_Model], data: Any, source: str) -> _Model:
    """Tables of a file as a `model`; `ValueError` in one line with path, key, value and rule if
    they don't fit. `source`: the file's name.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise _first_fault(error, source, data, model) from None


def _first_fault(
    error: ValidationError, source: str, data: Any, model: type[BaseModel]
) -> FileError:
    """Error of a file's first fault; arguments as of `validate`."""
    faults = error.errors(include_url=False)
    fault = min(faults, key=lambda x: _ORDER.get(x["type"], len(_ORDER)))
    kind, location = fault["type"], fault["loc"]
    path = [key for key in location if key not in (_PLAIN, _TABLE)]
    # a single muscle's name is empty
    keys = [key for i, key in enumerate(path) if key != "" or i != 1 or path[0] != "muscle"]
    if kind == "extra_forbidden":
        field = _field_at(model, location[:-1])
        section: Any = next(iter(_models(getattr(field, "annotation", None))), model)
        names = [known.alias or name for name, known in section.model_fields.items()]
        hint = did_you_mean(str(keys[-1]), names)
        return FileError(source, keys, f"unknown key{hint}")
    if kind == "missing":
        examples = getattr(_field_at(model, location), "examples", None) or [""]
        example = examples[0] if examples[0][:1] == "[" else f"{keys[-1]} = {examples[0]}"
        remedy = f", write {example}" if examples[0] else ""
        return FileError(source, keys, f"missing{remedy}.")
    rule = str(fault.get("ctx", {}).get("error") or _RULES.get(kind, fault["msg"]))
    for technical, plain in _PLAIN_WORDS.items():
        rule = rule.replace(technical, plain)
    count = f" ({len(faults) - 1} more after it)" if len(faults) > 1 else ""
    rule = rule if rule.endswith("?") else f"{rule.rstrip('.')}."
    return FileError(source, keys, f"{rule}{count}", value_at(data, path))


def did_you_mean(name: str, choices: Iterable[str]) -> str:
    """End of a sentence: `, did you mean "length"?` if a name is similar, else the choices."""
    names = sorted(choices)
    if similar := difflib.get_close_matches(name, names, n=1, cutoff=0.6):
        return f', did you mean "{similar[0]}"?'
    return f", choose one of {', '.join(names)}." if names else "."


def value_at(data: Any, keys: Iterable[Any]) -> Any:
    """The value in nested tables and lists at `keys`, or `None`."""
    for key in keys:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _toml_key(key: Any) -> str:
    """A key as TOML writes it, in quotes if necessary."""
    text = str(key)
    if isinstance(key, int) or re.fullmatch(r"[\w-]{1,40}", text, re.ASCII):
        return text
    quoted = json.dumps(text, ensure_ascii=False)
    return quoted if len(quoted) <= 42 else quoted[:40] + "…"


def _field_at(model: type[BaseModel], location: Sequence[Any]) -> Any:
    """Field of the model at a path, without names and indices that aren't fields."""
    field = None
    for key in location:
        fields: Mapping[Any, Any] = model.model_fields
        if key in fields:
            field = fields[key]
            model = next(iter(_models(field.annotation)), model)
    return field


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Models in an annotation such as `list[MotorUnitSection] | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    arguments = getattr(annotation, "__args__", ())
    return [model for argument in arguments for model in _models(argument)]
