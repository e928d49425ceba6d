"""Slow oracle: a muscle across a hinge, from its two attachment points and from virtual work.

The muscle runs from a point at the distance `a` from the pivot on one link to a point at the
distance `b` on the other. At the flexion `angle` (0: straight) the points are apart by the law of
cosines. Nothing here knows a moment arm: forces follow from the work over a small turn,
F (x(angle + h) - x(angle - h)) = torque 2 h, with the shortening x. Source: geometry alone.
"""

import math


STEP = 1e-5  # rad: the error of a central difference grows with its square, rounding with 1/step


def muscle_length(angle, a, b):
    """Distance of the attachment points [m] at a flexion `angle` [rad]."""
    return math.sqrt(a * a + b * b + 2 * a * b * math.cos(angle))


def moment_arm(angle, a, b):
    """Shortening of the muscle over a small turn [m]."""
    ends = muscle_length(angle - STEP, a, b), muscle_length(angle + STEP, a, b)
    return (ends[0] - ends[1]) / (2 * STEP)


def torque(force, angle, a, b):
    """Torque [N*m] of a `force` [N] by the work over a small turn."""
    return force * moment_arm(angle, a, b)


def arm_between(angle, angles, arms):
    """Straight line between the two entries of a table that enclose the `angle`."""
    for i in range(len(angles) - 1):
        if angles[i] <= angle <= angles[i + 1]:
            share = (angle - angles[i]) / (angles[i + 1] - angles[i])
            return arms[i] + share * (arms[i + 1] - arms[i])
    raise ValueError(angle)


def walked_shortening(start, end, angles, arms, steps=20_000):
    """Shortening [m] on the way from `start` to `end` [rad], summed over many small turns."""
    turn = (end - start) / steps
    return sum(arm_between(start + (i + 0.5) * turn, angles, arms) * turn for i in range(steps))
