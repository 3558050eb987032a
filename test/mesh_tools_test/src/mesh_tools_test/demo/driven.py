"""How the robot went to the goal."""
from typing import NamedTuple

import numpy as np

SPACING = 0.05  # meters between the positions of a track
HEADER = ("drive", "planned [m]", "driven [m]", "time [s]", "off goal [m]", "off heading [deg]")


class Driven(NamedTuple):
    """One drive, as the simulator saw it.

    outcome: its name; planned: length of the path [m]; track: (N,3) meters; seconds: of the
    simulation; distance [m], angle [rad]: from the goal and its heading, at the end.
    """

    outcome: str
    succeeded: bool
    message: str
    planned: float
    track: np.ndarray
    seconds: float
    distance: float
    angle: float

    @property
    def length(self):
        """Of the track [m]."""
        return float(np.linalg.norm(np.diff(self.track, axis=0), axis=1).sum())


class Track:
    """Positions SPACING apart, of a robot that moves."""

    def __init__(self):
        self._positions = []

    def add(self, position):
        """Note where the robot is; returns whether it has moved."""
        position = np.asarray(position, dtype=float)
        if self._positions and np.linalg.norm(position - self._positions[-1]) < SPACING:
            return False
        self._positions.append(position)
        return True

    @property
    def positions(self):
        """(N,3) meters."""
        return np.array(self._positions, dtype=float).reshape(-1, 3)


def turn_between(heading, other):
    """The angle [rad], 0 to pi, between two headings (3,) as seen from above."""
    turn = np.arctan2(heading[1], heading[0]) - np.arctan2(other[1], other[0])
    return float(abs((turn + np.pi) % (2 * np.pi) - np.pi))


def table(driven):
    """HEADER and one row of texts."""
    numbers = driven.planned, driven.length
    row = [driven.outcome, *(f"{value:.2f}" for value in numbers), f"{driven.seconds:.1f}"]
    return [HEADER, (*row, f"{driven.distance:.3f}", f"{np.degrees(driven.angle):.1f}")]
