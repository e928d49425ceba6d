"""`fascicle simulate --compare`: all policies on one scenario, their dips against their energy."""

import datetime as dt
import sys
from typing import TYPE_CHECKING, Any

from ..audited import audited
from ..outputs import Outputs, say
from ..printed import show
from ..problems import UserError, refusing
from ..telling import telling


if TYPE_CHECKING:
    from ...reports.compared import Ran

_DISTRUSTED = 1


def compare(read: Any, outputs: Outputs, report: str | None, overwrite: bool) -> int:
    """Run all policies.

    **Arguments:**

    - `read`: the scenario [-].
    - `outputs`: where the result goes [-].
    - `report`: where a page goes [-], or none.
    - `overwrite`: whether whatever stands there is replaced [-].

    **Returns:** the exit code [-]: 1 where a run can't be trusted.
    """
    if read.controlled is None:
        raise UserError(f"--compare: {read.name} is commanded by a schedule; it needs [control].")
    from ...plot.trajectory import PolicyCosts
    from ...plot.trajectory import policies as drawn
    from ...results.controlled import compared

    runs = _runs(read)
    controllers = {name: one.controlled.controller for name, one in runs.items()}
    worths = [one.worth for one in runs.values()]
    table = compared(controllers, worths, [not one.doubts for one in runs.values()])
    best = table["on_front"].values.tolist()

    def draw() -> Any:
        rows = ([w.drawdown for w in worths], [w.supply_energy for w in worths], best)
        pairs = {name: (one.run, one.demanded) for name, one in runs.items()}
        return drawn(read.plant, pairs, PolicyCosts(*rows))

    notes = " ".join(_notes(read, runs))
    title = f"Policies of {read.name}"
    outputs.give(table, lambda: _print(read, runs, best), draw, title=title, notes=notes)
    if report is not None:
        from ...files.ours import replacing
        from ...io.atomic import write_text
        from ...reports.compared import report as made

        today = f"{dt.datetime.now().astimezone():%Y-%m-%d}"
        with refusing("--report "), replacing(report, overwrite) as draft:
            write_text(draft, made(read, runs, best, draw(), today))
        if not (outputs.as_json or outputs.as_csv):
            say(f"wrote {report}")
    sys.stdout.flush()  # in this order, also where both go to one place
    doubted = {name: one.doubts for name, one in runs.items() if one.doubts}
    for name, doubts in doubted.items():
        say(f"{read.name}, {name}: can't be trusted: {'; '.join(doubts)}", error=True)
    return _DISTRUSTED if doubted else 0


def _runs(read: Any) -> "dict[str, Ran]":
    from ...control import POLICIES
    from ...reports.compared import Ran
    from ...reports.controlled import demanded, judged

    runs: dict[str, Ran] = {}
    with telling("simulating") as tell:
        for place, policy in enumerate(POLICIES, start=1):
            tell(f"simulating {policy}, policy {place} of {len(POLICIES)}")
            with refusing():
                one = read.taking(policy)
                run = one.run()
            _, doubts = audited(one.plant, run)
            followed = demanded(one, run)
            assert followed is not None
            runs[policy] = Ran(one.controlled, run, judged(one.controlled, run), followed, doubts)
    return runs


def _notes(read: Any, runs: "dict[str, Ran]") -> list[str]:
    from ...reports.compared import notes

    return [f"{note}." for note in notes(read, runs)]


def _print(read: Any, runs: "dict[str, Ran]", best: list[bool]) -> None:
    from ...reports.compared import heads, rows

    made = read.controlled
    told = "front: no other policy dips less for as much energy, or takes less for as deep a dip"
    of = made.controller.of
    title = f"Policies on {read.name}, control of {of}"
    show(title, heads(read.plant, of), rows(read.plant, of, runs, best), told)
    for note in _notes(read, runs):
        say(f"note: {note}")
