"""Where the vertices of a mesh are and how its faces and normals lie, as findings."""
from typing import Iterator, Optional

import numpy as np

from mesh_msgs_hdf5.formats.base.equal_rows import is_repeated
from mesh_msgs_hdf5.validation.findings import NOTE, WARNING, MapFinding
from mesh_msgs_hdf5.validation.validate_topology import found, has_repeated_vertex

_NO_AREA = 1e-6  # height / longest edge; about what float32 can tell from 0
_SLIVER = 1e-3
_COARSE = 1e-3  # meters
_UNIT = 1e-3


def check_shape(
    vertices: np.ndarray, faces: np.ndarray, normals: Optional[np.ndarray]
) -> Iterator[MapFinding]:
    """Findings about vertices (V, 3), faces (F, 3), and vertex normals (V, 3) or None."""
    from mesh_msgs_hdf5 import _surface  # only here: nodes need not load it

    largest = float(np.abs(vertices).max()) if len(vertices) else 0.0
    step = float(np.spacing(np.float32(largest)))
    if step > _COARSE:
        text = "coordinates up to %g m have steps of %g m in float32 (import with --origin auto)"
        yield MapFinding("far_from_origin", WARNING, "vertices", text % (largest, step))
    text = "vertices have the position of an earlier one (import with --merge-vertices"
    text += ", which makes copies of those along seams of textures)"
    plain = (vertices + np.float32(0)).view(np.uint32)  # -0 is 0
    yield from found("duplicate_vertices", "vertices", text, is_repeated(plain))
    # twice the areas, squares of the longest edges, signs of z of normals; normals of vertices
    areas, longest, up, around = _surface._shapes(vertices, faces)
    thin = areas <= _SLIVER * longest
    none = areas <= _NO_AREA * longest
    repeated = has_repeated_vertex(faces)  # another finding says so
    yield from found("zero_area", "faces", "faces have no area", none & ~repeated)
    text = "faces are thinner than 1/1000 of their longest edge"
    yield from found("sliver", "faces", text, thin & ~none, NOTE)
    down = areas[up < 0].sum()
    if down > areas[up > 0].sum():
        text = "%.0f %% of the area looks down: is the mesh upside down, or its faces clockwise?"
        yield from found("faces_down", "faces", text % (100 * down / areas.sum()), up < 0)
    if normals is not None:
        yield from _check_normals(normals, around)


def _check_normals(normals, around):
    length = np.linalg.norm(normals.astype(np.float64), axis=1)
    zero = length == 0
    yield from found("normal_zero", "vertex_normals", "normals have no direction (0)", zero)
    text = "normals are not of length 1"
    yield from found("normal_length", "vertex_normals", text, (abs(length - 1) > _UNIT) & ~zero)
    against = (around * normals).sum(axis=1) < 0
    text = "normals point against the faces around their vertices"
    yield from found("normal_flipped", "vertex_normals", text, against)
