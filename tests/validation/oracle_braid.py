"""The oracle of a pressurized braid that bends: fibers of fixed length, plain numbers.

Nothing here imports the library.
"""

import math

import numpy as np


def stiffness(pressure, radius, angle, step=1e-4):
    """Moment over curvature [N m2] of a braid bent to `step` over its radius, by summing what its
    fibers hold around the section.

    Around it they hold P r for each length of axis, everywhere: the section stays round. Along it
    they hold that times cot², by the angle at which fibers of fixed length lie where the axis is
    stretched by `step` times the cosine.
    """
    around = 2 * math.pi * (np.arange(4000) + 0.5) / 4000
    along = 1 + step * np.cos(around)  # stretch of a line on the outside of the bend
    # a fiber's square of length: what the axis takes of it, what is left for the circle
    axial = (math.cos(angle) * along) ** 2
    held = pressure * radius * axial / (1 - axial)
    moment = np.sum(held * radius * np.cos(around)) * radius * 2 * math.pi / 4000
    return moment * radius / step


def bent_volume(radius, angle, curvature, count=4000):
    """Volume [m3] for each meter of axis inside a braid bent to `curvature` [1/m], if its fibers
    don't slip: each piece of the wall keeps both of its fibers' lengths, and the section is as
    large as the lengths around it allow, a circle.
    """
    material = 2 * math.pi * np.arange(count) / count
    place = material.copy()  # where each piece of wall is around the section
    size = radius
    for _ in range(200):
        along = 1 + curvature * size * np.cos(place)
        hoop = np.sqrt((1 - (math.cos(angle) * along) ** 2) / math.sin(angle) ** 2)
        size = radius * np.mean(hoop)
        # places from the lengths around it, by the trapezoid rule, even about the outermost point
        steps = (hoop + np.roll(hoop, -1)) / 2
        new = np.concatenate([[0.0], np.cumsum(steps[:-1])]) * 2 * math.pi / np.sum(steps)
        if np.max(np.abs(new - place)) < 1e-14:
            break
        place = new
    return math.pi * size**2


def stiffness_without_slip(pressure, radius, angle, step=0.02):
    """By virtual work [N m2]: -P dV over half the square of the curvature, at two steps, with the
    error of fourth order taken out.
    """

    def rough(c):
        lost = math.pi * radius**2 - bent_volume(radius, angle, c / radius)
        return 2 * pressure * lost * (radius / c) ** 2

    return (4 * rough(step / 2) - rough(step)) / 3
