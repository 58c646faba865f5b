"""How alike the heights of a wall are at two places on it: what lumcal takes walls to be."""
from __future__ import annotations

import numpy as np
from scipy.special import j0

from ._solution import Array

WAVES_M = np.geomspace(0.8, 4.0, 9)
"""How long the waves of walls are."""

BOW_M = 3.0
"""How far a bow reaches."""


def waves(apart_m: Array) -> Array:
    """The covariance of waves of 1 m rms that run in all directions, between places so far apart."""
    made: Array = np.zeros_like(apart_m)
    for length in WAVES_M:
        made += j0(2 * np.pi / length * apart_m) / len(WAVES_M)
    return made


def bow(apart_m: Array) -> Array:
    """That of a face that is bent as a whole."""
    share = apart_m * (np.sqrt(3) / BOW_M)
    made: Array = (1 + share) * np.exp(-share)
    return made
