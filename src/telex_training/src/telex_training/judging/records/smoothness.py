"""Smoothness of movements: the spectral arc length (SPARC) of each sub-movement."""

from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

import numpy as np

RATE = 50.0
"""Of the speeds (Hz)."""
_HIGHEST = 10.0
_LEAST_SHARE = 0.05
_PADDING = 4
_MOVING = 0.005
_LEAST_DURATION = 0.3
_LONGEST_GAP = 0.1


def sparc(speeds: Sequence[float], rate: float = RATE) -> float:
    """Spectral arc length of one movement.

    By S. Balasubramanian, A. Melendez-Calderon, A. Roby-Brami, E. Burdet, On the analysis of
    movement smoothness, J. NeuroEng. Rehab. 12:112 (2015): the length of the curve that the
    magnitude of the speed's spectrum makes, scaled to 1 at zero frequency, over a band that ends
    where it last has 0.05, at 10 Hz at most, and that is itself scaled to 1.

    Parameters
    ----------
    speeds : sequence of float
        m/s; 2 at least, not all 0.
    rate : float
        Hz.

    Returns
    -------
    float
        Negative; nearer to 0 is smoother.
    """
    values = np.asarray(speeds, dtype=float)
    count = 2 ** (int(np.ceil(np.log2(len(values)))) + _PADDING)
    magnitudes = np.abs(np.fft.rfft(values, count))
    magnitudes /= magnitudes.max()
    frequencies = np.arange(len(magnitudes)) * (rate / count)
    magnitudes = magnitudes[frequencies <= _HIGHEST]
    strong = np.nonzero(magnitudes >= _LEAST_SHARE)[0]
    magnitudes = magnitudes[strong[0] : strong[-1] + 1]
    if len(magnitudes) < 2:
        return 0.0
    step = 1.0 / (len(magnitudes) - 1)
    return -float(np.sqrt(step * step + np.diff(magnitudes) ** 2).sum())


def sub_movements(speeds: Sequence[float], rate: float = RATE) -> List[Tuple[int, int]]:
    """Find where something moves: above 5 mm/s for 0.3 s or more, gaps below 0.1 s joined.

    Returns
    -------
    list of tuple of int
        Begin and end of each, as of a slice.
    """
    moving = np.concatenate([[False], np.asarray(speeds, dtype=float) > _MOVING, [False]])
    edges = np.nonzero(np.diff(moving.astype(np.int8)))[0]
    joined: List[List[int]] = []
    for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist()):
        if joined and (begin - joined[-1][1]) < _LONGEST_GAP * rate - 1e-9:
            joined[-1][1] = end
        else:
            joined.append([begin, end])
    least = _LEAST_DURATION * rate - 1e-9
    return [(begin, end) for begin, end in joined if end - begin >= least]


def mean_sparc(speeds: Sequence[float], rate: float = RATE) -> Optional[float]:
    """Mean SPARC of the sub-movements, weighted by their durations; None: there is none."""
    found = sub_movements(speeds, rate)
    if not found:
        return None
    total = sum(end - begin for begin, end in found)
    return sum(sparc(speeds[begin:end], rate) * (end - begin) for begin, end in found) / total
