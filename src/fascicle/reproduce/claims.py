"""A claim of a paper, held against what the model gives."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """What a paper says, in our words, and what came out.

    `where`: figure or section. `text`: the claim. `model`: what the model gives, with its
    numbers. `holds`: whether the two agree. `must_hold`: whether the reproduction has failed
    if they don't. `why`: where they differ, why.
    """

    where: str
    text: str
    model: str
    holds: bool
    must_hold: bool = False
    why: str = ""

    def __post_init__(self):
        if not self.holds and not self.must_hold and not self.why:
            raise ValueError(f"`why` must say why the claim differs: {self.text}")

    @property
    def verdict(self) -> str:
        """What came out: "holds" or "differs", "fails" where it had to hold."""
        if self.holds:
            return "holds"
        return "fails" if self.must_hold else "differs"


def failed(claims: Sequence[Claim]) -> list[Claim]:
    """The claims that had to hold and don't."""
    return [claim for claim in claims if claim.must_hold and not claim.holds]
