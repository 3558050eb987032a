"""A generated building of few large faces: one surface, without T-junctions."""

import numpy as np

from mesh_msgs.world.building import HEIGHT, LENGTH, WIDTH, building


def faces_at_edges(faces):
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0, return_counts=True)


def test_it_is_one_surface_of_few_large_faces_that_look_up():
    vertices, faces = building()
    a, b, c = vertices[faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    assert (normals[:, 2] > 0).all()
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    assert 1500 < areas.sum() < 2 * LENGTH * WIDTH and areas.max() > 20.0
    assert len(faces) < 500
    edges, counts = faces_at_edges(faces)
    assert counts.max() == 2
    levels = np.unique(vertices[:, 2])
    assert levels.astype(np.float32).tolist() == [0.0, np.float32(HEIGHT)]
    reached = {0}
    while True:
        near = edges[np.isin(edges, sorted(reached)).any(axis=1)]
        more = reached | set(near.ravel().tolist())
        if more == reached:
            break
        reached = more
    assert len(reached) == len(vertices)


def test_no_vertex_lies_on_an_edge_of_others():
    vertices, faces = building()
    edges, _ = faces_at_edges(faces)
    begins, ends = vertices[edges[:, 0]], vertices[edges[:, 1]]
    along = ends - begins
    squared = (along**2).sum(axis=1)
    for point in vertices:
        share = ((point - begins) * along).sum(axis=1) / squared
        away = np.linalg.norm(begins + share[:, None] * along - point, axis=1)
        assert not ((away < 1e-6) & (share > 1e-6) & (share < 1 - 1e-6)).any()
