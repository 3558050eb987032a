"""Where wheels get no further: steep ground, unless it is the side of a small step."""

import math
from typing import Optional

import numpy as np

from mesh_map.geometry import MeshGeometry
from mesh_map.walk import SurfaceWalk, WalkEnd

REACH = 5  # times the height of a step: how far its side may go, along a ramp or askew


class SteepGround:
    """Walks of a robot over a mesh. Which way faces are wound makes no difference."""

    def __init__(self, geometry: MeshGeometry, max_slope: Optional[float], max_step: float) -> None:
        """
        Args:
            geometry: the mesh.
            max_slope: rad; faces that are steeper stop the robot. None: none does.
            max_step: m; but not where they lead up or down by no more.
        """
        self._geometry, self._max_step = geometry, max_step
        self._gentle: Optional[np.ndarray] = None
        if max_slope is not None:
            upward = np.abs(geometry.face_normals @ geometry.up)
            gentle = upward >= math.cos(min(max_slope, math.pi / 2)) - 1e-6
            self._gentle = gentle | geometry.faces_without_area

    def walk(self, start: SurfaceWalk, length: float) -> SurfaceWalk:
        """Straight on (m, below 0: back) as far as it gets."""
        walker = self._geometry.walker
        walk = walker.walk(start=start, length=length, mask=self._gentle)
        if walk.end == WalkEnd.BLOCKED and self._is_step(walk, math.copysign(1.0, length)):
            return walker.walk(start=start, length=length)
        return walk

    def _is_step(self, walk: SurfaceWalk, sign: float) -> bool:
        """Whether what stopped a walk is so low that wheels climb it."""
        ahead = self._geometry.walker.walk(
            start=walk, length=sign * REACH * self._max_step, path=True
        )
        if ahead.path is None or self._gentle is None:
            return False
        steep = ~self._gentle[ahead.path.faces]
        if not steep.any():
            return False
        first = int(np.argmax(steep))
        rest = steep[first:]
        if rest.all():
            return False  # it does not end within reach
        last = first + int(np.argmin(rest))
        side = ahead.path.points[last] - ahead.path.points[first]
        return abs(float(side @ self._geometry.up)) <= self._max_step + 1e-6
