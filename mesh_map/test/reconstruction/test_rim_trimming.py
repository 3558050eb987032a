"""Rims that curl are taken away, and what bends for a reason stays."""

import numpy as np
from mesh_msgs import zoo

from mesh_map.reconstruction.rim_trimming import trim_rim, without_faces_at


def curled(rows, angle):
    """A level sheet of 2 x 2 m, edges of 0.1 m, the last rows of which stand up by an angle."""
    mesh = zoo.grid(20, 2.0)
    vertices = mesh.vertices.astype(float)
    beyond = np.maximum(0.0, vertices[:, 0] - (2.0 - 0.1 * rows))
    vertices[:, 0] -= beyond * (1.0 - np.cos(angle))
    vertices[:, 2] += beyond * np.sin(angle)
    return np.float32(vertices), mesh.faces


def test_curled_rows_at_the_border_are_taken_away():
    vertices, faces = curled(1, np.radians(80))
    trimmed = trim_rim(vertices, faces)
    assert len(trimmed.faces) == 2 * 20 * 19 and trimmed.vertices[:, 2].max() == 0.0
    assert trim_rim(trimmed.vertices, trimmed.faces) is None
    assert trim_rim(*curled(1, np.radians(40))) is None


def test_a_wall_is_no_rim():
    vertices, faces = curled(5, np.radians(90))  # but for two faces where its foot meets the border
    assert len(trim_rim(vertices, faces).faces) >= len(faces) - 2
    assert trim_rim(*curled(0, 0.0)) is None
    single = zoo.tetrahedron()
    assert trim_rim(single.vertices, single.faces[:3]) is None  # nothing lies behind


def test_faces_at_loops_go():
    mesh = zoo.grid(4, 4.0)
    left = without_faces_at(mesh.vertices, mesh.faces, [np.array([0]), np.array([24])])
    assert sorted(set(range(32)) - set(left.face_parents)) == sorted(
        np.flatnonzero(np.isin(mesh.faces, (0, 24)).any(axis=1))
    )
    assert without_faces_at(mesh.vertices, mesh.faces, [np.arange(25)]) is None
