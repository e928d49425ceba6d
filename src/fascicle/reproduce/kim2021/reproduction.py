"""The whole reproduction: every figure computed, drawn, written, and its claims reported.

Most of the time goes into compiling the laws, outside Python, so two chains of figures are
computed at once, and what is done is drawn meanwhile. What shares a law is in one chain.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from pathlib import Path

from ...describe.atomic import write_text
from ..claims import Claim
from ..record import Record, Written, write_record
from . import (
    alternatives,
    figure_02,
    figure_03,
    figure_04,
    figure_05,
    figure_06,
    figure_07,
    figure_08,
    figure_09,
    figure_10,
    figure_12,
    figure_12_calibrated,
    figure_13,
    figure_14,
)
from .report import claims_file, report


Progress = Callable[[int, int, str], object]
Compute = Callable[[], Record]

FIGURES: tuple[Compute, ...] = tuple(
    module.compute
    for module in (
        figure_02, figure_03, figure_04, figure_05, figure_06, figure_07, figure_08, figure_09,
        figure_10, figure_12, figure_12_calibrated, figure_13, figure_14,
    )
)  # fmt: skip
ALTERNATIVES: tuple[Compute, ...] = alternatives.RECORDS
CHAINS: tuple[tuple[Compute, ...], ...] = (
    tuple(m.compute for m in (figure_06, figure_02, figure_03, figure_04, figure_05, figure_07,
                              figure_08, figure_12)),
    (figure_10.compute,),
    (figure_13.compute, figure_14.compute),
    (figure_09.compute,),
    (figure_12_calibrated.compute,),
    ALTERNATIVES,
)  # fmt: skip
_AT_ONCE = 2


def run(out: Path, progress: Progress | None = None) -> list[Claim]:
    """Make everything in folder `out`; see `fascicle.reproduce.kim2021.run`."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    told = progress or (lambda _done, _total, _what: None)
    futures: dict[Compute, Future[Record]] = {
        compute: Future() for chain in CHAINS for compute in chain
    }
    order = {future: compute for compute, future in futures.items()}
    written: dict[Compute, Written] = {}
    pool = ThreadPoolExecutor(_AT_ONCE)
    try:
        for chain in CHAINS:
            pool.submit(_work_through, chain, futures)
        told(0, len(futures), "compiling the laws")
        for future in as_completed(order):
            record = future.result()
            told(len(written), len(futures), record.name)
            written[order[future]] = write_record(record, folder)
    finally:
        for future in futures.values():
            future.cancel()  # the chains end with the figure that they are at
        pool.shutdown(wait=False, cancel_futures=True)
    figures = [written[compute] for compute in FIGURES]
    second = [written[compute] for compute in ALTERNATIVES]
    claims = [claim for one in figures for claim in one.record.claims]
    write_text(folder / "claims.json", claims_file(claims))
    write_text(folder / "report.html", report(figures, second))
    told(len(futures), len(futures), "done")
    return claims


def _work_through(chain: Sequence[Compute], futures: dict[Compute, "Future[Record]"]) -> None:
    for compute in chain:
        future = futures[compute]
        if not future.set_running_or_notify_cancel():
            return
        try:
            future.set_result(compute())
        except BaseException as error:  # noqa: BLE001 handed to whoever waits for it
            future.set_exception(error)
