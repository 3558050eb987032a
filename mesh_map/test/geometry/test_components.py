"""What hangs together: by vertices, by edges."""

import numpy as np
import pytest

from mesh_map.geometry.components import components, drop_components


def test_pieces_that_meet_in_a_vertex_alone_are_several_on_request():
    vertices = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [9, 9, 0]])
    faces = np.uint32([[0, 1, 2], [0, 3, 4], [1, 5, 2]])
    assert components(vertices, faces).count == 1
    found = components(vertices, faces, across_vertices=False)
    assert found.count == 2 and found.of_faces.tolist() == [0, 1, 0]
    assert drop_components(vertices, faces, min_faces=2) is None
    dropped = drop_components(vertices, faces, min_faces=2, across_vertices=False)
    assert dropped.face_parents.tolist() == [0, 2]


@pytest.mark.parametrize("across", [True, False])
def test_of_random_faces_pieces_are_those_of_a_search(across):
    random = np.random.default_rng(3)
    for _ in range(30):
        faces = np.sort(random.permuted(np.tile(np.arange(14), (9, 1)), axis=1)[:, :3], axis=1)
        vertices = random.random((14, 3)).astype(np.float32)
        found = components(vertices, faces.astype(np.uint32), across_vertices=across)
        shared = (faces[:, None, :, None] == faces[None, :, None, :]).any(3).sum(2)
        together = shared >= (1 if across else 2)
        reached = np.linalg.matrix_power(together.astype(np.int64), 9) > 0
        same = found.of_faces[:, None] == found.of_faces[None]
        assert np.array_equal(reached, same)
