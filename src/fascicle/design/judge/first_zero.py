"""The first strain at which a force over even strains vanishes, linear between two of them."""

from ...core.array_namespace import array_namespace, minimum, where
from ...core.types import AnyArray, Float, Int, Numbers


def first_push(force: Float[AnyArray, "*any strain"]) -> Int[AnyArray, "*any"]:
    """The first strain after rest at which a force doesn't pull.

    **Arguments:** `force`: over strains, on the last axis [N].

    **Returns:** its place [-]; the last, if there is none.
    """
    at_work = array_namespace(force)
    place = at_work.arange(force.shape[-1])
    pushes = ((force <= 0) & (place > 0)) | (place == force.shape[-1] - 1)
    return at_work.argmax(pushes, axis=-1)


def share(left: Numbers, right: Numbers) -> Numbers:
    """How far from one strain to the next a force vanishes.

    **Arguments:** `left`, `right`: at both [N].

    **Returns:** the share of the way [-].
    """
    # the last of all may still pull by rounding: it is the zero itself
    drop = left - minimum(right, 0.0)
    return where(left > 0, left / where(drop > 0, drop, 1.0), 0.0)
