"""Errors of motions that add up as real ones do."""

import math
from typing import NamedTuple

import numpy as np


class Motion(NamedTuple):
    """A short piece of a drive, on the ground or as wheels count it."""

    way: float
    """m."""
    turn: float
    """To the left (rad)."""


class MotionNoise:
    """Errors whose variance is proportional to the motion, so that the steps do not matter."""

    def __init__(self, share: float, seed: int) -> None:
        """
        Args:
            share: standard deviation (m) of the way after 1 m, (rad) of the heading after 1 m, and
                (rad) after turning by 1 rad.
            seed: the same seed makes the same errors.
        """
        if not 0 <= share < math.inf:
            raise ValueError(f"noise of motions is {share}, but has to be >= 0 and finite")
        self._share = share
        self._random = np.random.default_rng(seed)

    def on(self, motion: Motion) -> Motion:
        """The motion with errors; none where there is no motion."""
        if self._share == 0:
            return motion
        way, bend, turn = self._share * self._random.standard_normal(3)
        root = math.sqrt(abs(motion.way))
        return Motion(
            motion.way + way * root,
            motion.turn + bend * root + turn * math.sqrt(abs(motion.turn)),
        )
