"""A claim of a paper, in its words and ours, and the number that decides whether it holds.

Not all that a paper says of its model is a prediction of it. What was chosen so that a
statement comes out, a constant or the reading of a unit, can't then count that statement as
one that holds; and what an equation says outright holds whatever the muscle does. So each
claim has a kind, and predictions are counted apart. Where the paper can be read in several ways,
each claim is judged by each reading; and where a limit is ours and a claim only just keeps it, that
is said.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from fascicle.core.errors import InvalidInputError


KINDS: Mapping[str, str] = MappingProxyType({
    "prediction": "what the model gives without having been told",
    "input": "what something was chosen, or fitted, to meet: a check of the choice, not of the "
    "model",
    "definition": "what an equation or an assumption says outright: a check of the code alone",
})  # fmt: skip
SIGNS = ("<", ">", "=", "≤")
_CLOSE = 0.1  # of a limit, or of what it leaves: so near a number may have decided the limit
_ROUNDING = 1e-12
_MET = {"prediction": "holds", "input": "chosen", "definition": "by definition"}


@dataclass(frozen=True)
class Criterion:
    """A number of the model against a limit: it must be below, `<`, at most that, `≤`, above, `>`,
    or within `tolerance` of it, `=`. `quantity` says what it is, `ours` why this limit where the
    paper gives none, `scale` the size that the number is compared with where such a limit is zero.
    """

    quantity: str
    value: float
    sign: str
    limit: float
    unit: str = ""
    tolerance: float = 0.0
    ours: str = ""
    scale: float = 0.0

    def __post_init__(self):
        if self.sign not in SIGNS:
            raise InvalidInputError("sign", f"must be one of {', '.join(SIGNS)}", self.sign)

    @property
    def met(self) -> bool:
        """Whether the number is where it must be; what is not a number is not."""
        if self.sign == "<":
            return bool(self.value < self.limit)
        if self.sign == ">":
            return bool(self.value > self.limit)
        if self.sign == "≤":
            return bool(self.value <= self.limit)
        return bool(abs(self.value - self.limit) <= self.tolerance)

    @property
    def close(self) -> bool:
        """Whether the limit is ours and near the number, so that another one might decide
        otherwise.
        """
        # a limit of zero has no size of its own
        room, scale = abs(self.value - self.limit), self.scale or abs(self.limit)
        if self.sign == "=":
            room, scale = abs(self.tolerance - room), self.tolerance
        return bool(self.ours and room < _CLOSE * scale)

    @property
    def whose(self) -> str:
        """Whose limit it is, in brackets; empty where it is the paper's."""
        near = ", close to the number" if self.close else ""
        return f" (our limit{near})" if self.ours else ""

    @property
    def text(self) -> str:
        """As a reader checks it: the quantity, its value, and what it must be."""
        unit = f" {self.unit}" if self.unit else ""
        about = f" ± {self.tolerance:.2g}" if self.sign == "=" and self.tolerance else ""
        must = f"{self.sign} {self.limit:.4g}{about}{unit}"
        # what is rounding is shown as none
        value = self.value if abs(self.value) > _ROUNDING else 0.0
        return f"{self.quantity}: {value:.4g}{unit}, must be {must}"


@dataclass(frozen=True)
class Reading:
    """A claim by another reading of the paper: the reading's `name`, whether it `holds` by it, and
    the numbers of its criteria.
    """

    name: str
    holds: bool
    numbers: tuple[str, ...]


@dataclass(frozen=True)
class Claim:
    """What a paper says and what came out.

    `key`: its name in the file. `where`: section or figure. `kind`: one of `KINDS`. `text`: the
    claim in our words, `quote`: in the paper's. `criteria`: what decides. `model`: what the
    model gives. `why`: where the two are known to differ, why; a claim without it must hold.
    `chosen`: of an input, what was chosen to meet it. `readings`: the same claim by the paper's
    other readings.
    """

    key: str
    where: str
    kind: str
    text: str
    quote: str
    criteria: tuple[Criterion, ...]
    model: str
    why: str = ""
    chosen: str = ""
    readings: tuple[Reading, ...] = ()

    def __post_init__(self):
        if self.kind not in KINDS:
            raise InvalidInputError("kind", f"must be one of {', '.join(KINDS)}", self.kind)
        if not self.criteria:
            raise InvalidInputError(
                "criteria", f"must hold one or more, or {self.key} can't fail", None
            )
        if (self.kind == "input") != bool(self.chosen):
            raise InvalidInputError(
                "chosen", "must say what was chosen, of an input alone", None, f"{self.key}"
            )

    @property
    def holds(self) -> bool:
        """Whether all criteria are met."""
        return all(one.met for one in self.criteria)

    @property
    def turned(self) -> tuple[Reading, ...]:
        """The readings by which the verdict is another."""
        return tuple(one for one in self.readings if one.holds is not self.holds)

    @property
    def dependence(self) -> str:
        """On which reading the verdict depends, in a sentence; empty where none was tried."""
        if not self.readings:
            return ""
        if not self.turned:
            return "The same by every reading."
        told = "; ".join(f"{one.name} ({'; '.join(one.numbers)})" for one in self.turned)
        way = "does not hold" if self.holds else "holds"
        same = [one.name for one in self.readings if one.holds is self.holds]
        rest = f"; the same by {', '.join(same)}" if same else ""
        return f"Depends on the reading: {way} by {told}{rest}."

    @property
    def must_hold(self) -> bool:
        """Whether the reproduction has failed if it doesn't: no difference is known."""
        return not self.why

    @property
    def verdict(self) -> str:
        """What came out: "holds", "chosen" or "by definition", by kind; else "differs" where
        that is known, and "fails".
        """
        if self.holds:
            return _MET[self.kind]
        return "fails" if self.must_hold else "differs"


def over(part: float, whole: float) -> float:
    """One number over another, as a criterion takes it: not a number where the other is zero."""
    return float(part) / float(whole) if whole else math.nan


def failed(claims: Sequence[Claim]) -> list[Claim]:
    """The claims that had to hold and don't."""
    return [claim for claim in claims if claim.must_hold and not claim.holds]


def of_kind(claims: Sequence[Claim], kind: str) -> list[Claim]:
    """The claims of a `kind` [-], in order."""
    return [claim for claim in claims if claim.kind == kind]


def summary(claims: Sequence[Claim]) -> str:
    """One line that counts predictions apart from what was chosen and what is defined."""
    count = {kind: Counter(one.verdict for one in of_kind(claims, kind)) for kind in KINDS}
    predicted, chosen, defined = count.values()
    parts = []
    if predicted.total():
        parts.append(
            f"{predicted['holds']} of {predicted.total()} predictions hold{_rest(predicted)}"
        )
    if chosen.total():
        parts.append(f"{_inputs(chosen['chosen'])} chosen to meet the paper's words{_rest(chosen)}")
    if defined.total():
        one = defined["by definition"] == 1
        parts.append(
            f"{defined['by definition']} {'is a definition' if one else 'are definitions'}"
            f"{_rest(defined)}"
        )
    return "; ".join(parts) + "."


def remarks(claims: Sequence[Claim]) -> list[str]:
    """Sentences on which claims depend on a reading, and which on a limit of ours that is close."""
    turned = [
        f"{claim.key} ({', '.join(one.name for one in claim.turned)})"
        for claim in claims
        if claim.turned
    ]
    close = [claim.key for claim in claims if any(one.close for one in claim.criteria)]
    told = []
    if turned:
        told.append(f"The verdict depends on the reading of the paper for {', '.join(turned)}.")
    elif any(claim.readings for claim in claims):
        told.append("Every verdict is the same by every reading of the paper.")
    if close:
        told.append(f"A limit that is ours and close to the number decides {', '.join(close)}.")
    return told


def as_data(claims: Sequence[Claim]) -> dict[str, Any]:
    """The `claims` [-] as JSON takes them, with their summary; what is no number is null."""
    return {
        "summary": summary(claims),
        "remarks": remarks(claims),
        "kinds": dict(KINDS),
        "claims": [_claim_data(claim) for claim in claims],
    }


def _inputs(number: int) -> str:
    return f"{number} input was" if number == 1 else f"{number} inputs were"


def _rest(count: Counter[str]) -> str:
    """What differs or fails of a kind, so that no sum hides it."""
    said = {"differs": f"{count['differs']} differ" + ("s" if count["differs"] == 1 else ""),
            "fails": f"{count['fails']} fail" + ("s" if count["fails"] == 1 else "")}  # fmt: skip
    return "".join(f", {text}" for verdict, text in said.items() if count[verdict])


def _claim_data(claim: Claim) -> dict[str, Any]:
    return {
        "key": claim.key,
        "where": claim.where,
        "kind": claim.kind,
        "verdict": claim.verdict,
        "claim": claim.text,
        "paper": claim.quote,
        "criteria": [_criterion_data(one) for one in claim.criteria],
        "model": claim.model,
        "chosen": claim.chosen,
        "why": claim.why,
        "dependence": claim.dependence,
        "readings": {one.name: one.holds for one in claim.readings},
    }


def _criterion_data(one: Criterion) -> dict[str, Any]:
    return {
        "quantity": one.quantity,
        "value": float(one.value) if math.isfinite(one.value) else None,
        "sign": one.sign,
        "limit": float(one.limit),
        "unit": one.unit,
        "tolerance": float(one.tolerance),
        "ours": one.ours,
        "close": one.close,
        "met": one.met,
        "text": one.text + one.whose,
    }
