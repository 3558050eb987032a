"""What the recorder has noted of a robot: its commands and its poses, by their times."""

from pathlib import Path
from typing import List, Tuple

import numpy as np

STILL = 0.2  # s; after so much time without motion a command to stand is a stop


class Record:
    """Reads on in the file of the recorder.

    Attributes:
        commands: (s monotonic, the fastest of m/s and rad/s) of each command.
        poses: (s monotonic, x, y in m) of each true pose.
    """

    def __init__(self, path: Path) -> None:
        self._file = open(path, encoding="ascii")
        self._rest = ""
        self.commands: List[Tuple[float, float]] = []
        self.poses: List[Tuple[float, float, float]] = []

    def update(self) -> None:
        """All that was noted until now."""
        *lines, self._rest = (self._rest + self._file.read()).split("\n")
        for line in lines:
            kind, *values = line.split()
            if kind == "command":
                self.commands.append((float(values[0]), float(values[1])))
            else:
                self.poses.append((float(values[0]), float(values[1]), float(values[2])))

    def close(self) -> None:
        """No more updates."""
        self._file.close()

    @property
    def moving(self) -> bool:
        """Whether the last command was to move."""
        return bool(self.commands) and self.commands[-1][1] > 0.0

    def position(self) -> np.ndarray:
        """(2,) m, the newest; NaN before."""
        return np.array(self.poses[-1][1:] if self.poses else (np.nan, np.nan))

    def positions(self, begin: float) -> np.ndarray:
        """(N,2) m, from that time on (s)."""
        return np.array([pose[1:] for pose in self.poses if pose[0] >= begin]).reshape(-1, 2)

    def stop_after(self, begin: float) -> float:
        """When the first command to stand came that no motion followed for `STILL`; the beginning
        if the last command before was one already, inf if none came (s)."""
        speeds = [(when, speed) for when, speed in self.commands if when >= begin]
        before = [speed for when, speed in self.commands if when < begin]
        if before and before[-1] == 0.0:
            speeds.insert(0, (begin, 0.0))
        moves = [when for when, speed in speeds if speed > 0.0]
        for when, speed in speeds:
            if speed == 0.0 and not any(when <= move < when + STILL for move in moves):
                return when
        return np.inf

    def moves_between(self, begin: float, end: float) -> int:
        """How many commands to move came after one time and before another (s)."""
        return sum(begin < when < end for when, speed in self.commands if speed > 0.0)
