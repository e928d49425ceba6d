"""The oracle of the laws published for Festo's muscles: their formulas, in their own units.

Nothing here imports the library. Constants as public code of another group has them
(Agile-and-Adaptive-Robotics/Bipedal_Robot, Code/Matlab/Functions: ModelComparison2.m, f_festo.m and
maxBPAforce.m), which names the papers they are from.
"""

import math


SAROSI = {  # bar and percent
    "sarosi_10": (-9.2194029, 203.7012413, -0.34221042, -3.2255991, 109.2038216, -208.372034),
    "sarosi": (-4.00180705, 292.4620246, -0.32930845, -9.33564098, 294.0538256, -280.498151),
    "sarosi_20_400": (-4.35573, 281.22370, -0.32866, -9.27035, 302.20107, -263.69185),
}  # fmt: skip
MARTENS = {  # Pa, m: polynomial of E in the length, a correction of 28.6 deg in rad, inner diameter
    "martens2017": ((74.085e6, -689.20e6, 1.837e9, -848.79e6), -0.1, 0.010, 0.250),
    "martens2017_20": ((93.232e6, -715.29e6, 1.5483e9, -502.95e6), -0.073, 0.020, 0.300),
}
BOLEN = {  # a0, a1, a3; then N/kPa and 1/(kPa m)
    "bolen": ((0.5682, 4.254, 0.5597), (0.4895, 0.03068)),
    "bolen_20": ((0.2579, 6.477, 1.321), (1.4877, 0.0248)),
}


def sarosi(name, bar, percent):
    a, b, c, d, e, f = SAROSI[name]
    return (a * bar + b) * math.exp(c * percent) + d * bar * percent + e * bar + f


def martens(name, pressure, length):
    (c0, c1, c2, c3), correction, D0, L0 = MARTENS[name]
    wall, angle = 0.0018, math.radians(28.6) + correction
    fiber = L0 / math.cos(angle)
    turns = L0 * math.tan(angle) / (math.pi * D0)
    left = math.sqrt(fiber**2 - length**2)
    D = left / (math.pi * turns)
    volume_slope = (fiber**2 - 3 * length**2) / (4 * math.pi * turns**2)
    diameter_slope = -length / left / (math.pi * turns)
    E = c0 + c1 * length + c2 * length**2 + c3 * length**3
    around = E * (D - D0) / D0 * wall * math.pi * length
    along = E * (length - L0) / L0 * wall * math.pi * D
    return -pressure * volume_slope + around * diameter_slope - along


def bolen(name, kPa, strain, largest_strain, length):
    (a0, a1, a3), (b1, b2) = BOLEN[name]
    relative, share = strain / largest_strain, kPa / 620
    largest = 620 * b1 * math.atan(b2 * (length - 0.0075) * 620)
    return largest * (a0 * (math.exp(-a1 * relative) - 1) + share * math.exp(-a3 * relative**2))
