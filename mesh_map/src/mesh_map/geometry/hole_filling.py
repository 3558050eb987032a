"""Holes closed: loops of the border that are short and flat get faces."""

import math
from enum import IntEnum
from typing import Any, Dict, NamedTuple, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh, derived_uuid

from mesh_map import _kernels
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.normals import checked_up
from mesh_map.geometry.submesh import checked_mesh
from mesh_map.geometry.topology import quantity

# So many new faces at most, unless another limit is given.
FACE_LIMIT = 10_000_000
_VERSION = 1  # another number gives all results other UUIDs
# Faces side by side that enclose a sharper angle than 30 degrees lie back on each other.
_FOLD = math.radians(150.0)


class LoopFate(IntEnum):
    """What became of a loop of the border."""

    FILLED = 0
    OUTER = 1
    LONG = 2
    UNEVEN = 3
    STEEP = 4
    FOLDED = 5
    CROSSING = 6


# Why a loop was left open, for people.
_LEFT_OPEN = {
    LoopFate.OUTER: "the outer border of a component",
    LoopFate.LONG: "longer than the limit",
    LoopFate.UNEVEN: "not flat enough",
    LoopFate.STEEP: "too steep",
    LoopFate.FOLDED: "not to be closed without faces that lie back on others",
    LoopFate.CROSSING: "not to be closed without crossing the surface",
}


class HoleFilling(NamedTuple):
    """What fill_holes() has made of each loop of the border.

    derived: the mesh, or None where no hole was closed.
    fates: (L,) uint8, a LoopFate for each loop, in the order of border_loops().
    perimeters: (L,) float64 meters.
    deviations: (L,) float64 meters, how far each loop leaves its best plane.
    open_edges: border edges that are in no loop, see BorderLoops.
    new_faces: (F,) bool, which faces close holes; of derived, or of the mesh where that is None.
    face_loops: (K,) uint32, for each face that closes a hole its loop, ascending.
    """

    derived: Optional[DerivedMesh]
    fates: np.ndarray
    perimeters: np.ndarray
    deviations: np.ndarray
    open_edges: int
    new_faces: np.ndarray
    face_loops: np.ndarray

    def counts(self) -> Dict[str, int]:
        """The name of each fate in lower case -> the number of loops that had it."""
        numbers = np.bincount(self.fates, minlength=len(LoopFate)).tolist()
        return {fate.name.lower(): numbers[fate] for fate in LoopFate}

    def report(self) -> str:
        """One line for people."""
        counts = self.counts()
        text = "%s of %s closed by %s" % (
            quantity(counts["filled"], "holes"),
            quantity(len(self.fates), "border loops"),
            quantity(int(np.count_nonzero(self.new_faces)), "faces"),
        )
        left = [
            "%s %s" % (format(counts[fate.name.lower()], ","), why)
            for fate, why in _LEFT_OPEN.items()
            if counts[fate.name.lower()]
        ]
        if self.open_edges:
            left.append("%s in no loop" % quantity(self.open_edges, "border edges"))
        return text + ("; left open: " + ", ".join(left) if left else "")


def fill_holes(
    vertices: Any,
    faces: Any,
    *,
    max_perimeter: float = 1.0,
    flatness: float = 0.1,
    max_slope: float = 90.0,
    keep_outer: bool = True,
    refine: bool = True,
    up: Any = (0.0, 0.0, 1.0),
    parent_uuid: str = "",
    face_limit: int = FACE_LIMIT,
) -> HoleFilling:
    """A mesh whose small, flat holes are closed.

    Of the triangulations of a loop, the one is taken that bends the least, and then that of the
    smallest area (P. Liepa: Filling holes in meshes, 2003). New vertices make edges as long as
    those around; they have the values of the loop, interpolated. A new face belongs to the face of
    the mesh at the nearest side of the loop, so that it has its labels. New faces are turned as
    those beside. They have no edge that the mesh has elsewhere, do not cross it, and do not lie
    back on it: a loop that cannot be closed so stays open.

    Vertices and faces of the mesh come first, in their order, then new ones. The result depends on
    the arguments alone.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices. Of edges with more than two faces, and where faces are turned
            against each other, no hole is closed: see make_manifold().
        max_perimeter: meters; only shorter loops are closed, so doorways stay.
        flatness: how far a loop may leave its best plane, in parts of its perimeter.
        max_slope: degrees, 0 to 90; loops whose best plane is steeper stay, such as windows.
        keep_outer: the longest loop of a component stays open where it is at least half as large as
            the component: the outer border of a piece of ground, however small.
        refine: False for faces between the vertices of the loop alone.
        up: (3,) of any length, which slopes refer to.
        parent_uuid: identity of the mesh; that of the result follows from it.
        face_limit: so many new faces at most.
    Raises:
        MeshMapError: a limit out of its range, or too many faces; no mesh: what is wrong.
    """
    for name, value, most in (
        ("max_perimeter", max_perimeter, math.inf),
        ("flatness", flatness, math.inf),
        ("max_slope", max_slope, 90.0),
    ):
        if not 0.0 <= value <= most:
            raise MeshMapError(
                "%s is %g, but it has to be 0 or more%s"
                % (name, value, "" if most == math.inf else ", and %g at most" % most)
            )
    direction = checked_up(up)
    vertices, faces = checked_mesh(vertices, faces)
    slope = math.inf if max_slope == 90.0 else math.radians(max_slope)
    try:
        found = _kernels._hole_filling(
            vertices,
            faces,
            max_perimeter,
            flatness,
            slope,
            _FOLD,
            keep_outer,
            refine,
            direction,
            face_limit,
        )
    except ValueError as error:
        raise MeshMapError(
            "holes cannot be closed: %s" % error, "a smaller max_perimeter would do"
        ) from error
    loops = found["fates"], found["perimeters"], found["deviations"], found["open_edges"]
    new_count = len(found["faces"])
    new_faces = np.arange(len(faces) + new_count) >= len(faces)
    if not new_count:
        return HoleFilling(None, *loops, new_faces, found["face_loops"])
    own = np.arange(len(vertices), dtype=np.uint32)
    own_weights = np.zeros((len(vertices), 3))
    own_weights[:, 0] = 1.0
    parameters = {
        "max_perimeter": max_perimeter,
        "flatness": flatness,
        "max_slope": max_slope,
        "keep_outer": keep_outer,
        "refine": refine,
        "up": direction.tolist(),
        "version": _VERSION,
    }
    weights = np.clip(found["vertex_weights"], 0.0, 1.0)
    derived = DerivedMesh(
        derived_uuid(parent_uuid, "holes filled", parameters),
        parent_uuid,
        np.concatenate([vertices, found["points"]]),
        np.concatenate([faces, found["faces"]]),
        face_parents=np.concatenate(
            [np.arange(len(faces), dtype=np.uint32), found["face_parents"]]
        ),
        vertex_parents=np.concatenate([np.repeat(own[:, None], 3, 1), found["vertex_parents"]]),
        vertex_weights=np.concatenate([own_weights, weights]),
        parent_vertex_count=len(vertices),
        parent_face_count=len(faces),
    )
    return HoleFilling(derived, *loops, new_faces, found["face_loops"])
