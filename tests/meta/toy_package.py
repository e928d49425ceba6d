"""A package on top of fascicle: a scheme and an objective of its own, from public names alone."""

import fascicle as fs
from fascicle.design import Outcome, objective


@fs.schemes.register
class Pairs(fs.schemes.AbstractScheme):
    """Two units at a time: those before them at supply pressure, the two at one throttled one."""

    name = "pairs"

    def states(self, units: int):
        """A state for every two."""
        return [
            fs.schemes.State(full=range(k), throttled=range(k, min(k + 2, units)))
            for k in range(0, units, 2)
        ]


@objective(unit="J", sense="max")
def work_done(outcome: Outcome):
    """Work of the task's points that are reached [J]."""
    return (outcome.reached * outcome.work).sum(axis=0)


def bundle() -> fs.Bundle:
    """Four equal motor units, recruited two by two."""
    muscle = fs.Muscle(0.127, 6.35e-3, 1.6e-3, 0.576)
    return fs.Bundle([fs.MotorUnit(muscle)] * 4, supply_pressure=413.7e3, scheme="pairs")
