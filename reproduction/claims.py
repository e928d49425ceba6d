"""Claims of a paper, in its words and ours, with the numbers that decide on them.

Not all that a paper says of its model is a prediction of it. What was chosen so that a statement
comes out, a constant or the reading of a unit, can't then count that statement as one that holds.
What an equation says outright holds whatever the muscle does. A statement on data that the paper
doesn't give can't be tested. So each claim has a kind, and predictions are counted separately.
Where the paper can be read in several ways, each claim is judged by each reading; and where the
limit is ours and the number is close to it, that is said.

The claims of a paper stand in a TOML file, with the limits that decide; code gives the numbers.
"""

import math
import tomllib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from fascicle.core.errors import InvalidInputError


KINDS: Mapping[str, str] = MappingProxyType({
    "prediction": "results of the model that nothing was chosen to match",
    "input": "results that a constant was chosen or fitted to match: a check of the choice, not of "
    "the model",
    "definition": "statements of an equation or an assumption: a check of the code alone",
    "not testable here": "statements that rest on measured data that the paper does not give",
})  # fmt: skip
_COMPARE: Mapping[str, Callable[[float, float], bool]] = {
    "<": lambda value, limit: value < limit,
    ">": lambda value, limit: value > limit,
    "≤": lambda value, limit: value <= limit,
}
SIGNS = (*_COMPARE, "=")
_CLOSE = 0.1  # of a limit, or of what it leaves: so near a number may have decided the limit
_ROUNDING = 1e-12  # less than this is shown as zero
_MET = {
    "prediction": "holds", "input": "chosen", "definition": "by definition",
    "not testable here": "not testable here",
}  # fmt: skip


@dataclass(frozen=True)
class Criterion:
    """A number of the model against a limit: it must be below, `<`, at most that, `≤`, above, `>`,
    or within `tolerance` of it, `=`. `quantity` names the number; `limit_reason` says why this
    limit where the paper gives none; `scale` is the size that the number is compared with where
    such a limit is zero.
    """

    quantity: str
    value: float
    sign: str
    limit: float
    unit: str = ""
    tolerance: float = 0.0
    limit_reason: str = ""
    scale: float = 0.0

    def __post_init__(self):
        if self.sign not in SIGNS:
            raise InvalidInputError("sign", f"must be one of {', '.join(SIGNS)}", self.sign)

    @property
    def met(self) -> bool:
        """True if the number meets its limit; NaN never does."""
        if self.sign == "=":
            return bool(abs(self.value - self.limit) <= self.tolerance)
        return bool(_COMPARE[self.sign](self.value, self.limit))

    @property
    def close(self) -> bool:
        """True if the limit is ours and near the number: another limit might decide otherwise."""
        # a limit of zero has no size of its own
        room, scale = abs(self.value - self.limit), self.scale or abs(self.limit)
        if self.sign == "=":
            room, scale = abs(self.tolerance - room), self.tolerance
        return bool(self.limit_reason and room < _CLOSE * scale)

    @property
    def limit_note(self) -> str:
        """Remark in brackets on a limit of ours; empty for one of the paper's."""
        note = ", close to the number" if self.close else ""
        return f" (our limit{note})" if self.limit_reason else ""

    @property
    def text(self) -> str:
        """Quantity, value and limit in words."""
        unit = f" {self.unit}" if self.unit else ""
        about = f" ± {self.tolerance:.2g}" if self.sign == "=" and self.tolerance else ""
        must = f"{self.sign} {self.limit:.4g}{about}{unit}"
        value = self.value if abs(self.value) > _ROUNDING else 0.0
        return f"{self.quantity}: {value:.4g}{unit}, must be {must}"

    @property
    def data(self) -> dict[str, Any]:
        """Entry of `claims.json`; NaN is null there."""
        return {
            "quantity": self.quantity,
            "value": float(self.value) if math.isfinite(self.value) else None,
            "sign": self.sign, "limit": float(self.limit), "unit": self.unit,
            "tolerance": float(self.tolerance), "ours": self.limit_reason, "close": self.close,
            "met": self.met, "text": self.text + self.limit_note,
        }  # fmt: skip


@dataclass(frozen=True)
class Reading:
    """A claim by another reading of the paper: the reading's `name`, its `condition`, a clause
    that begins with "if", whether the claim `holds`, and the numbers of its criteria.
    """

    name: str
    condition: str
    holds: bool
    numbers: tuple[str, ...]


@dataclass(frozen=True)
class Claim:
    """A statement of a paper and what came out.

    `key`: its name in the file. `place`: section or figure. `kind`: one of `KINDS`. `text`: the
    claim in our words, `quote`: in the paper's. `criteria`: what decides. `outcome`: what the
    model gives. `explanation`: of a difference that is known; a claim without it must hold.
    `choice`: of an input, what was chosen to meet it. `readings`: the claim by the paper's other
    readings.
    """

    key: str
    place: str
    kind: str
    text: str
    quote: str
    criteria: tuple[Criterion, ...]
    outcome: str
    explanation: str = ""
    choice: str = ""
    readings: tuple[Reading, ...] = ()

    def __post_init__(self):
        if self.kind not in KINDS:
            raise InvalidInputError("kind", f"must be one of {', '.join(KINDS)}", self.kind)
        if not self.criteria:
            raise InvalidInputError(
                "criteria", f"must hold one or more, or {self.key} can't fail", None
            )
        if (self.kind == "input") != bool(self.choice):
            raise InvalidInputError(
                "choice", "must say what was chosen, of an input alone", None, f"{self.key}"
            )

    @property
    def holds(self) -> bool:
        """True if all criteria are met."""
        return all(criterion.met for criterion in self.criteria)

    @property
    def opposite_readings(self) -> tuple[Reading, ...]:
        """Readings by which the verdict is another."""
        return tuple(reading for reading in self.readings if reading.holds is not self.holds)

    @property
    def dependence(self) -> str:
        """Sentence on the readings that the verdict depends on; empty without readings."""
        if not self.readings:
            return ""
        if not self.opposite_readings:
            return "The same with every reading."
        numbers = "; ".join(
            f"{reading.condition} ({'; '.join(reading.numbers)})"
            for reading in self.opposite_readings
        )
        verdict = "does not hold" if self.holds else "holds"
        rest = len(self.readings) - len(self.opposite_readings)
        suffix = f". The same with the other {rest}" if rest else ""
        return f"Depends on the reading: it {verdict} {numbers}{suffix}."

    @property
    def verdict(self) -> str:
        """One of "holds", "chosen", "by definition" and "not testable here", by kind; else
        "differs" where a difference is known, and "fails".
        """
        if self.holds or self.kind == "not testable here":
            return _MET[self.kind]
        return "differs" if self.explanation else "fails"

    @property
    def data(self) -> dict[str, Any]:
        """Entry of `claims.json`."""
        return {
            "key": self.key, "where": self.place, "kind": self.kind, "verdict": self.verdict,
            "claim": self.text, "paper": self.quote,
            "criteria": [criterion.data for criterion in self.criteria],
            "model": self.outcome, "chosen": self.choice, "why": self.explanation,
            "dependence": self.dependence,
            "readings": {reading.name: reading.holds for reading in self.readings},
        }  # fmt: skip


def claim_builder(path: Path) -> Callable[..., Claim]:
    """Read a file of claims; returns a function of a claim's key, numbers and outcome.

    A limit that itself is computed comes with the number: a pair of it and the fields to replace.
    """
    table = tomllib.loads(path.read_text(encoding="utf-8"))

    def claim(key: str, values: Sequence[Any], outcome: str) -> Claim:
        words = dict(table[key])
        criteria = []
        for entry, value in zip(words.pop("criteria"), values, strict=True):
            sign, *limit = entry["must"].split()
            number, fields = value if isinstance(value, tuple) else (value, {})
            fields = {name: entry[name] for name in entry if name != "must"} | fields
            if limit:
                fields["limit"] = float(limit[0])
            criteria.append(Criterion(value=float(number), sign=sign, **fields))
        return Claim(key=key, criteria=tuple(criteria), outcome=outcome, **words)

    return claim


def over(part: float, whole: float) -> float:
    """Ratio of two numbers; NaN for a `whole` of zero, which meets no criterion."""
    return float(part) / float(whole) if whole else math.nan


def failed(claims: Sequence[Claim]) -> list[Claim]:
    """Claims that fail."""
    return [claim for claim in claims if claim.verdict == "fails"]


def of_kind(claims: Sequence[Claim], kind: str) -> list[Claim]:
    """Claims of a `kind`, in order."""
    return [claim for claim in claims if claim.kind == kind]


def summary(claims: Sequence[Claim]) -> str:
    """Line with the counts of predictions, inputs and definitions."""
    phrases = {
        "prediction": lambda n, total: f"{n} of {total} predictions hold",
        "input": lambda n, total: f"{n} of {total} inputs match the paper by choice",
        "definition": lambda n, _: f"{n} claim{' holds' if n == 1 else 's hold'} by definition",
        "not testable here": lambda n, _: f"{n} can't be tested here",
    }
    parts = []
    for kind, phrase in phrases.items():
        count = Counter(claim.verdict for claim in of_kind(claims, kind))
        if count.total():
            parts.append(phrase(count[_MET[kind]], count.total()))
            for verb in ("differ", "fail"):  # so that no sum hides it
                if n := count[f"{verb}s"]:
                    parts[-1] += f", {n} {verb}{'s' * (n == 1)}"
    return "; ".join(parts) + "."


def remarks(claims: Sequence[Claim]) -> list[str]:
    """Sentences on the readings that change a verdict, and on limits of ours that are close. Claims
    are named by their number in the list.
    """
    changed: dict[str, list[int]] = {}
    for number, claim in enumerate(claims, start=1):
        for reading in claim.opposite_readings:
            changed.setdefault(reading.condition, []).append(number)
    close = [
        number
        for number, claim in enumerate(claims, start=1)
        if any(criterion.close for criterion in claim.criteria)
    ]
    sentences = [
        f"{condition[:1].upper()}{condition[1:]}, the verdict changes on {_numbered(numbers)}."
        for condition, numbers in changed.items()
    ]
    all_conditions = {reading.condition: None for claim in claims for reading in claim.readings}
    unchanged = [condition for condition in all_conditions if condition not in changed]
    if unchanged:
        sentences.append(f"No verdict changes {'; '.join(unchanged)}.")
    if close:
        sentences.append(
            "A limit that the paper does not give, and that is close to the number, decides"
            f" {_numbered(close)}."
        )
    return sentences


def _numbered(numbers: Sequence[int]) -> str:
    """Claims by their `numbers`, in words."""
    if len(numbers) == 1:
        return f"claim {numbers[0]}"
    return f"claims {', '.join(map(str, numbers[:-1]))} and {numbers[-1]}"


def claims_data(claims: Sequence[Claim]) -> dict[str, Any]:
    """Content of `claims.json`: claims with their summary."""
    return {
        "summary": summary(claims), "remarks": remarks(claims), "kinds": dict(KINDS),
        "readings": {
            reading.name: reading.condition for claim in claims for reading in claim.readings
        },
        "claims": [claim.data for claim in claims],
    }  # fmt: skip
