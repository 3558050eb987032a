"""Worlds of an exact number of triangles are what the generator makes, cut or refined."""
import numpy as np
import pytest

from mesh_msgs.outdoor_world import outdoor_world
from mesh_tools_test.base import exact_world as module
from mesh_tools_test.base.exact_world import exact_world


def area(vertices, faces):
    a, b, c = (vertices[faces[:, k]].astype(np.float64) for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def check(vertices, faces, count):
    assert faces.shape == (count, 3) and faces.dtype == np.uint32
    assert vertices.shape[1] == 3 and vertices.dtype == np.float32
    assert np.array_equal(np.unique(faces), np.arange(len(vertices)))
    assert (faces[:, 0] != faces[:, 1]).all() and (faces[:, 1] != faces[:, 2]).all()


@pytest.mark.parametrize("count", [1000, 9_999, 20_001, 30_000])
def test_it_has_exactly_as_many_faces(count):
    vertices, faces = exact_world(count)
    check(vertices, faces, count)
    again = exact_world(count)
    assert np.array_equal(again[0], vertices) and np.array_equal(again[1], faces)


@pytest.fixture(scope="module")
def generated():
    return outdoor_world(faces=20_000)


@pytest.mark.parametrize("difference", [-301, -300, -1, 0, 1, 2, 300, 301])
def test_what_is_too_much_is_cut_and_what_lacks_is_split(monkeypatch, generated, difference):
    world = generated
    monkeypatch.setattr(module, "outdoor_world", lambda faces, seed: world)
    count = len(world.faces) + difference
    vertices, faces = exact_world(count)
    check(vertices, faces, count)
    whole, left = area(world.vertices, world.faces).sum(), area(vertices, faces).sum()
    if difference >= 0 and difference % 2 == 0:
        assert left == pytest.approx(whole, rel=1e-6)  # splits change no shape
    else:
        assert 0.97 * whole < left < whole
    if difference < 0:  # what is kept are faces of the world, in their order
        corners, expected = vertices[faces], world.vertices[world.faces]
        kept = {triangle.tobytes() for triangle in corners}
        assert np.array_equal(corners, [t for t in expected if t.tobytes() in kept])


def test_sizes_that_the_generator_does_not_make_are_refused():
    with pytest.raises(ValueError, match="faces = 10"):
        exact_world(10)
