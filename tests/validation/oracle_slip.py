"""The oracle of sliding springs: walked step by step, with nothing known of loops.

Written before the library's closed form of a loop's width.
"""

from itertools import pairwise


def walked(stiffness, slip, places):
    """Force after each place, of springs that begin at ease: each bends until it slips."""
    springs = [0.0] * len(stiffness)
    forces = [0.0]
    for before, now in pairwise(places):
        for j, (k, f) in enumerate(zip(stiffness, slip, strict=True)):
            springs[j] = max(-f, min(f, springs[j] + k * (now - before)))
        forces.append(sum(springs))
    return forces


def widths(stiffness, slip, stroke, steps, loops=4):
    """Force there less force back at each of `steps + 1` places of the last of several loops: a
    friction that opposes contraction takes as much from the pull there, and adds it back.
    """
    there = [stroke * i / steps for i in range(steps + 1)]
    way = there[:1]
    for _ in range(loops):
        way += there[1:] + there[-2::-1]
    forces = walked(stiffness, slip, way)
    last = forces[-(2 * steps + 1) :]
    return [up - down for up, down in zip(last[: steps + 1], last[steps:][::-1], strict=True)]
