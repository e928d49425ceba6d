"""At which levels a noisy quantity was held, and which readings were taken at each."""

import numpy as np


HELD = 0  # number of the first level; a reading at none of them has −1
_BINS = 8192
_FEWEST = 3  # readings at a level
_SHARE = 2e-3  # of the record's readings, that a level has at least
_MOST_LEVELS = 1000


def smoothed(values: np.ndarray, width: int) -> np.ndarray:
    """Running median [-] over `width` readings [-]: noise falls, steps stay where they are."""
    if width < 3 or values.size < width:
        return values
    half = width // 2
    padded = np.pad(values, half, mode="edge")
    out = np.empty_like(values)
    for start in range(0, values.size, 100_000):  # bounds the memory that windows take
        part = padded[start : start + 100_000 + 2 * half]
        windows = np.lib.stride_tricks.sliding_window_view(part, 2 * half + 1)
        out[start : start + windows.shape[0]] = np.median(windows, axis=1)
    return out


def noise(values: np.ndarray) -> float:
    """Standard deviation [-] of the noise on `values` [-], by their second differences."""
    if values.size < 4:
        return 0.0
    return 1.4826 * float(np.median(np.abs(np.diff(values, 2)))) / 6**0.5


def held(values: np.ndarray, tolerance: float) -> np.ndarray:
    """Which level each of `values` was taken at.

    The level with most readings within the tolerance is found first, and taken off; and so
    on, while there are levels with enough of them.

    **Arguments:**

    - `values`: readings [-].
    - `tolerance`: how far they lie from their level at most, in their unit [-].

    **Returns:** the level's number from 0, or −1 for none [-].
    """
    low, span = float(np.min(values)), float(np.ptp(values))
    if span <= 2 * tolerance:
        return np.zeros(values.size, dtype=int)
    width = max(span / _BINS, tolerance / 4)
    bins = np.minimum(((values - low) / width).astype(int), int(span / width))
    counts = np.bincount(bins, minlength=int(span / width) + 1)
    reach = max(int(tolerance / width), 0)
    least = max(_FEWEST, int(_SHARE * values.size))
    centers: list[float] = []
    left = counts.copy()
    for _ in range(_MOST_LEVELS):
        window = np.convolve(left, np.ones(2 * reach + 1, dtype=int), mode="same")
        best = int(np.argmax(window))
        if window[best] < least:
            break
        places = np.arange(max(best - reach, 0), min(best + reach + 1, left.size))
        center = low + width * (0.5 + float(np.average(places, weights=left[places])))
        left[places] = 0
        # the tails of a level that is already there are no level of their own
        if all(abs(center - other) > 2 * tolerance + width for other in centers):
            centers.append(center)
    if not centers:
        return np.full(values.size, -1)
    ordered = np.sort(centers)
    nearest = np.searchsorted((ordered[1:] + ordered[:-1]) / 2, values)
    inside = np.abs(values - ordered[nearest]) <= tolerance + width
    return np.where(inside, nearest, -1)
