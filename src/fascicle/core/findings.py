"""Findings: what a computation noticed, as codes and numbers; their words are in `report`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum


class Severity(IntEnum):
    """How much a finding matters: the most first in every output."""

    ERROR = 0
    WARNING = 1
    NOTE = 2


@dataclass(frozen=True)
class Finding:
    """Something that a computation noticed: its `code` in the catalogue of words, such as
    "gauge.force_zero", a contract as keys of JSON are; and numbers [SI] and names in `data`.
    """

    code: str
    severity: Severity
    data: Mapping[str, object] = field(default_factory=dict)

    def to_json(self) -> dict[str, object]:
        """Code, severity and data in one table."""
        return {"code": self.code, "severity": self.severity.name.lower(), **self.data}
