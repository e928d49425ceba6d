"""Measured records that are in reach, against every law: what each errs by, and what it misses.

The records are public or a lab's own, and not in the repository: they are looked for under
`FASCICLE_DATA`, or beside the checkout. A record is a CSV as `fascicle calibrate` reads it, with
the muscle that it is of, by its nominal sizes, in a file beside it.
"""

from .found import Measured, measured_records
from .judged import Judged, judged
from .report import nothing, run


__all__ = ["Judged", "Measured", "judged", "measured_records", "nothing", "run"]
