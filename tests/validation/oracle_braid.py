"""The oracle of a pressurized braid that bends: fibers of fixed length, plain numbers.

Nothing here imports the library.
"""

import math

import numpy as np
from scipy.optimize import minimize


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


def stiffness_of_any_section(pressure, radius, angle):
    """The same at the neutral angle, where the axis is as long as it likes, with sections of any
    shape: the volume is made largest over all of them, step by step around half of the section.
    """
    count, shapes = 200, 3
    around = (np.arange(count) + 0.5) * math.pi / count
    waves = np.sin(np.outer(around, np.arange(1, shapes + 1)))

    def section(state, bend):
        """Volume over that of a meter of a circle of radius 1, and how far it is from closing."""
        axis, turn = 1 + state[0], around + math.pi / 2 + waves @ state[1:]
        x, y, volume = 1.0, 0.0, 0.0
        for cosine, sine in zip(np.cos(turn), np.sin(turn), strict=True):
            middle = x
            for _ in range(2):  # to the middle of the step, where the hoop's length is taken
                along = (math.cos(angle) * axis * (1 + bend * middle)) ** 2
                step = math.sqrt((1 - along) / math.sin(angle) ** 2) * math.pi / count
                middle = x + 0.5 * step * cosine
            volume += (middle + 0.5 * bend * middle**2) * step * sine
            x, y = x + step * cosine, y + step * sine
        return 2 * volume * axis / math.pi, y

    def largest(bend):
        found = minimize(
            lambda state: -section(state, bend)[0], np.zeros(1 + shapes), method="SLSQP",
            constraints={"type": "eq", "fun": lambda state: section(state, bend)[1]},
            options={"ftol": 1e-15, "maxiter": 300},
        )  # fmt: skip
        return -found.fun

    round_one = largest(0.0)
    rough = [2 * math.pi * (round_one - largest(bend)) / bend**2 for bend in (0.05, 0.1)]
    return pressure * radius**4 * (4 * rough[0] - rough[1]) / 3
