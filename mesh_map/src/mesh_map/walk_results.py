"""Where walks over a surface end."""

import enum
import math
from typing import NamedTuple, Optional, Sequence

import numpy as np


class WalkEnd(enum.IntEnum):
    """Why a walk ended.

    ARRIVED: all of the length was walked, or a line came to its target.
    BORDER: the surface ends there.
    BLOCKED: the next face is not in the mask.
    STEPS: there were more faces than max_steps.
    NOWHERE: no walk at all: no face, one without area, barycentric coordinates of no point in it, a
        number that is not finite, or no direction along the face.
    LOOP: a line came to where it has been: its cut does not lead to the target, as round a peak
        that leans over. Its length has no meaning.
    """

    ARRIVED = 0
    BORDER = 1
    BLOCKED = 2
    STEPS = 3
    NOWHERE = 4
    LOOP = 5


class WalkPath(NamedTuple):
    """The way of a walk.

    points: (N + 1, 3) float64, meters: the start, each crossing of an edge, and the end.
    faces: (N,) uint32; face i has the points i and i + 1.
    """

    points: np.ndarray
    faces: np.ndarray


class SurfaceWalk(NamedTuple):
    """The end of a walk: a pose on the surface from which to walk on.

    face: index; that of the start where there was no walk.
    position: (3,) float64, meters.
    barycentric: (3,) float64, weights of the corners of the face.
    direction: (3,) float64 of length 1 along the face: where the walker looks. A line of no length
        looks nowhere (zeros).
    normal: (3,) float64 of length 1, of the face, to the side of the surface on which he is.
    length: meters that were walked, >= 0, in either direction.
    end: why it ended.
    path: the way, if it was asked for.
    """

    face: int
    position: np.ndarray
    barycentric: np.ndarray
    direction: np.ndarray
    normal: np.ndarray
    length: float
    end: WalkEnd
    path: Optional[WalkPath] = None

    def turned(self, angle: float) -> "SurfaceWalk":
        """The same pose looking this angle (radians) farther to the left."""
        # Number by number: robots turn in every step, and np.cross takes ten times as long.
        (a, b, c), (x, y, z) = self.normal.tolist(), self.direction.tolist()
        left = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
        return self._replace(direction=math.cos(angle) * self.direction + math.sin(angle) * left)

    def matrix(self) -> np.ndarray:
        """(4, 4), from the frame of the walker (x ahead, y left, z up) to that of the mesh."""
        result = np.eye(4)
        left = np.cross(self.normal, self.direction)
        result[:3] = np.stack([self.direction, left, self.normal, self.position], 1)
        return result


class SurfaceWalks(NamedTuple):
    """The ends of N walks as arrays; see SurfaceWalk.

    faces: (N,) uint32.
    positions, barycentric, directions, normals: (N, 3) float64.
    lengths: (N,) float64.
    ends: (N,) uint8 of WalkEnd.
    paths: one for each, if they were asked for.
    """

    faces: np.ndarray
    positions: np.ndarray
    barycentric: np.ndarray
    directions: np.ndarray
    normals: np.ndarray
    lengths: np.ndarray
    ends: np.ndarray
    paths: Optional[Sequence[WalkPath]] = None

    def walk(self, index: int) -> SurfaceWalk:
        """One of them."""
        return SurfaceWalk(
            int(self.faces[index]),
            self.positions[index],
            self.barycentric[index],
            self.directions[index],
            self.normals[index],
            float(self.lengths[index]),
            WalkEnd(int(self.ends[index])),
            None if self.paths is None else self.paths[index],
        )
