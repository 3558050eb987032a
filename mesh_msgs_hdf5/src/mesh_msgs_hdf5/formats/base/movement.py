"""A mesh moved as a whole by a 4 x 4 matrix: positions, normals, and which side is outside."""
import re
from typing import Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model.carried_mesh import carried_parameters
from mesh_msgs_hdf5.model.mesh import Features, Mesh

Origin = Tuple[float, float, float]
# x right, y up, z to the viewer becomes x, -z, y: z up (REP 103)
Y_TO_Z_UP = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])


def mirrors(matrix: np.ndarray) -> bool:
    """Whether a matrix (its first three rows and columns count) turns a left hand into a right."""
    return bool(np.linalg.det(matrix[:3, :3]) < 0)


def moved_normals(normals: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(N, 3) of length 1: normals of a surface that was moved; what has no length keeps none."""
    turn = matrix[:3, :3]
    # normals go with the inverse transposed, here times the determinant
    cofactors = np.stack([np.cross(turn[(i + 1) % 3], turn[(i + 2) % 3]) for i in range(3)])
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        turned = normals.astype(np.float64) @ cofactors.T
        turned *= np.sign(np.linalg.det(turn))
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        return turned / np.where(length > 0, length, 1)


def moved_positions(
    positions: np.ndarray, offset: Origin, matrix: np.ndarray
) -> Tuple[np.ndarray, Origin]:
    """(float64 (N, 3), offset) of positions that are near an offset; without one there is none."""
    with np.errstate(invalid="ignore", over="ignore"):
        moved = positions.astype(np.float64) @ matrix[:3, :3].T
        if not any(offset):
            return moved + matrix[:3, 3], offset
        place = matrix[:3, :3] @ np.array(offset) + matrix[:3, 3]
        return moved, (float(place[0]), float(place[1]), float(place[2]))


def move_rest(mesh: Mesh, matrix: np.ndarray, before: Origin, report: ImportReport) -> None:
    """All but the vertices of a mesh, which were moved already; before: its origin then."""
    if mirrors(matrix):
        mesh.faces = np.ascontiguousarray(mesh.faces[:, ::-1])
        report.note("the transform mirrors: faces were turned over, so that outside stays outside")
    if mesh.vertex_normals is not None:
        normals = moved_normals(mesh.vertex_normals, matrix)
        mesh.vertex_normals = normals.astype(np.float32)
    if mesh.features is not None:
        absolute = mesh.features.locations.astype(np.float64) + before
        moved, _ = moved_positions(absolute, (0.0, 0.0, 0.0), matrix)
        places = (moved - np.array(mesh.origin)).astype(np.float32)
        mesh.features = Features(places, mesh.features.descriptors)
    # what they were computed with was another geometry
    by = "a movement of the mesh"
    mesh.layer_parameters = carried_parameters(mesh.vertex_costs, mesh.layer_parameters, by)


def parsed_matrix(text: str) -> Optional[np.ndarray]:
    """The 16 numbers in a text, row by row, as (4, 4); None if it has other things in it."""
    words = re.sub(r"[\[\](),;]", " ", text).split()
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        return None
    return np.array(numbers).reshape(4, 4) if len(numbers) == 16 else None


def matrix_fault(matrix: np.ndarray) -> Tuple[str, str]:
    """What is wrong with a matrix that is to move a mesh, and the way out; "" if nothing is."""
    if not np.isfinite(matrix).all():
        return "not all of its numbers are finite", ""
    if not np.array_equal(matrix[3], [0, 0, 0, 1]):
        if np.array_equal(matrix[:, 3], [0, 0, 0, 1]):
            return "it stands column by column", "transpose it: the last row is 0 0 0 1"
        return "its last row is not 0 0 0 1", "it is written row by row"
    if np.linalg.matrix_rank(matrix[:3, :3]) < 3:
        return "it makes everything flat", ""
    return "", ""
