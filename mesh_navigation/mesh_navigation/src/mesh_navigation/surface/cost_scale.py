"""Costs of a mesh as the numbers and states of a costmap: those that clients know."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from mesh_map.base.errors import MeshMapError

HIGHEST_FREE = 252
INSCRIBED, LETHAL, UNKNOWN = 253, 254, 255
MOST = 2**32 - 1  # what a uint32 holds


class State(IntEnum):
    """What a place is like, from best to worst; constants of the check services of mbf_msgs."""

    FREE = 0
    INSCRIBED = 1
    LETHAL = 2
    UNKNOWN = 3
    OUTSIDE = 4


class Factors(NamedTuple):
    """By which costs of one state are multiplied; 0 counts as 1."""

    lethal: float = 1.0
    inscribed: float = 1.0
    unknown: float = 1.0

    def checked(self) -> "Factors":
        """With 1 for 0.

        Raises:
            MeshMapError: one that is negative or not finite.
        """
        for name, factor in self._asdict().items():
            if not 0.0 <= factor < np.inf:
                raise MeshMapError(f"the factor for {name} costs is {factor}, not 0 or more")
        return Factors(*(factor or 1.0 for factor in self))


def states_of(costs: np.ndarray, cost_limit: float) -> np.ndarray:
    """(N,) uint8 of `State`, of costs of vertices: FREE up to the limit, INSCRIBED above it."""
    states = np.where(costs <= cost_limit, State.FREE, State.INSCRIBED)
    states = np.where(np.isposinf(costs), State.LETHAL, states)
    return np.where(np.isnan(costs), State.UNKNOWN, states).astype(np.uint8)


def scaled(costs: np.ndarray, cost_limit: float) -> np.ndarray:
    """(N,) float64, of costs of vertices: 0 to 252 up to the limit, in proportion to it; 253 above
    it, 254 lethal, 255 unknown."""
    states = states_of(costs, cost_limit)
    shares = costs.astype(np.float64) / cost_limit if cost_limit > 0 else np.zeros(len(costs))
    free = np.rint(HIGHEST_FREE * np.where(states == State.FREE, shares, 0.0))
    return np.choose(states, [free, INSCRIBED, LETHAL, UNKNOWN])


def total(costs: np.ndarray, cost_limit: float, factors: Factors) -> int:
    """The sum of scaled costs, times the factors; at most `MOST`."""
    weights = np.array([1.0, factors.inscribed, factors.lethal, factors.unknown])
    found = scaled(costs, cost_limit) * weights[states_of(costs, cost_limit)]
    return int(min(MOST, np.rint(found.sum())))
