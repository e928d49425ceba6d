"""Whether a run in time can be trusted."""

from typing import Any


def audited(plant: Any, run: Any) -> tuple[Any, list[str]]:
    """The audit of a `run` of a `plant` [-], or none of a chamber that keeps no balance, and why
    not to trust it, in words [-].
    """
    from ..dynamics import audit, events

    found, doubts = None, []
    try:
        found = audit(plant, run)
    except ValueError as error:
        doubts.append(str(error).rstrip("."))
    doubts += [
        f"the {one.name} doesn't close, {one.share:.1e} of its largest term is left over"
        f" ({one.closes_within:g} would pass)" + (f": {one.remedy}" if one.remedy else "")
        for one in (found.balances if found else ())
        if not one.closes
    ]
    doubts += [
        f"{one.name} from {one.first:g} s, {one.words}" for one in events(run) if not one.trusted
    ]
    return found, doubts
