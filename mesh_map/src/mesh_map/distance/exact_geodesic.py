"""Locally shortest paths over a surface."""

from typing import Any, Optional

import numpy as np

from mesh_map import _kernels
from mesh_map.base.array_checks import read_only
from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.errors import Canceled
from mesh_map.base.query_arguments import mask_array, points_array, whole_number
from mesh_map.distance.surface_path import SurfacePath
from mesh_map.geometry.mesh_geometry import MadeOnce, MeshGeometry
from mesh_map.geometry.walk import walk_arrays

MAX_TURNS = 10_000_000  # ways around vertices that are tried for one path


class ExactGeodesic(MadeOnce):
    """Pulls paths over a mesh taut, until they are geodesics: straight where the faces that they
    cross are unfolded into a plane, and bent only at vertices around which every way is 180 degrees
    or more, or that the surface (or what of it counts) does not go around (Mitchell, Mount and
    Papadimitriou, The discrete geodesic problem, 1987).

    With that no path nearby is shorter. Which side of a hill a path takes is up to what is given:
    what follows a wave front takes the shorter one, but for such as differ by less than the error
    of the front.

    Any triangle soup will do. The same path gives the same result, and any thread may ask at any
    time; the GIL is released meanwhile.
    """

    def __init__(self, geometry: MeshGeometry) -> None:
        """Prepares the mesh."""
        arrays = walk_arrays(geometry.vertices, geometry.faces, geometry.topology)
        self._face_count = len(geometry.faces)
        self._kernel = _kernels._Geodesics(*arrays)

    def shorten(
        self,
        path: SurfacePath,
        *,
        mask: Optional[Any] = None,
        over_hills: bool = False,
        max_turns: int = MAX_TURNS,
        cancel: Optional[CancelFlag] = None,
    ) -> SurfacePath:
        """The locally shortest path that a path becomes when it is pulled taut.

        Both ends stay exactly where they are. It is never longer than what was given: a geodesic
        comes back as it is, but for its potentials.

        Args:
            path: points within the faces that they are said to be in.
            mask: (F,) bool, the faces that may be entered; None for all. Where the path is in
                others and does not run along the edge of one that counts, it stays as it is.
            over_hills: True to look for a shorter path on the other side of each vertex beside it
                with less than 360 degrees of surface around it, too: rough ground has many paths
                that are taut.
            max_turns: ways around vertices to try before it gives up and returns the path as short
                as it is by then.
            cancel: ends this when it is set.
        Returns:
            The path; its potentials are the lengths that remain (meters).
        Raises:
            ValueError: a point that is not in its face (the first is named), a mask of another
                type or length, or a number of turns out of its range.
            Canceled: by `cancel`.
        """
        points, faces, _, _, cancelled = self._kernel._shorten(
            points_array(path.points, "the points of a path"),
            _face_array(path.faces),
            mask_array(mask, self._face_count),
            over_hills,
            whole_number(max_turns, "max_turns"),
            kernel_flag(cancel),
        )
        if cancelled:
            raise Canceled("the shortest path was cancelled")
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        remaining = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
        return SurfacePath(
            points=read_only(points), faces=read_only(faces), potentials=read_only(remaining)
        )


def _face_array(faces: Any) -> np.ndarray:
    array = np.asarray(faces)
    if array.size and array.dtype.kind not in "iu":
        raise ValueError("the faces of a path have to be whole numbers, not %s" % array.dtype)
    if array.size and (array.min() < 0 or array.max() > 0xFFFFFFFF):
        raise ValueError("the faces of a path have to be indices of faces of the mesh")
    return np.ascontiguousarray(array, np.uint32)
