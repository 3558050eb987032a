"""Which faces obstacles stand on, and how marks are kept."""

import math

import numpy as np
import pytest
from mesh_map.layers import obstacles
from mesh_map.layers.obstacles import ObstacleMarks, find_obstacles
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex
from meshes import small, terrain
from obstacle_oracles import faces_below

DOWN = np.array([0.0, 0.0, -1.0])
ALL = {"nearest": 0.0, "farthest": math.inf, "lowest": 0.0, "highest": math.inf}
LIMITS = [
    ALL,
    {**ALL, "highest": 0.6},
    {**ALL, "lowest": 0.15, "highest": 0.8},
    {**ALL, "nearest": 0.5, "farthest": 1.5, "lowest": 0.3},
]


@small
@pytest.mark.parametrize("limits", LIMITS)
def test_faces_below_points_equal_brute_force(mesh, limits):
    random = np.random.default_rng(7)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    points = random.uniform(low - 0.2, high + 0.5, (60, 3))
    points[::10] = [np.nan, np.inf, 1e300]
    origin = (low + high) / 2.0
    for down in (DOWN, np.array([0.3, -0.2, -2.0])):
        index = SpatialIndex(mesh.vertices, mesh.faces)
        found = find_obstacles(index, points, origin, down, **limits)
        unit = down / np.linalg.norm(down)
        starts, reach = points - limits["lowest"] * unit, limits["highest"] + limits["lowest"]
        with np.errstate(all="ignore"):  # of points that are not finite
            below = faces_below(mesh.vertices, mesh.faces, starts, unit, reach)
        for point, finite, inside, ground, face, expected, way, close in zip(
            points, *found, *below
        ):
            if not np.isfinite(point).all():
                assert not (finite or inside or ground) and face == NO_FACE
                continue
            assert finite
            distance = math.dist(point, origin)
            assert inside == (limits["nearest"] <= distance <= limits["farthest"])
            if close:
                continue
            low_enough = inside and expected != NO_FACE and way < 2 * limits["lowest"]
            assert ground == low_enough
            assert face == (expected if inside and not low_enough else NO_FACE)


def test_the_comparison_meets_all_kinds_of_points():
    mesh = terrain(20)
    points = np.random.default_rng(1).uniform((-0.5, -0.5, -0.5), (2.5, 2.5, 2.0), (500, 3))
    index = SpatialIndex(mesh.vertices, mesh.faces)
    found = find_obstacles(index, points, np.array([1.0, 1.0, 0.5]), DOWN, **LIMITS[3])
    counts = [found.ground.sum(), (found.faces != NO_FACE).sum(), (~found.in_range).sum()]
    assert min(counts) > 20, counts


def test_a_point_just_below_the_upper_floor_is_ground_not_an_obstacle_below():
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    vertices = np.concatenate([square, square + np.float32([0, 0, 3])])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.uint32)
    index = SpatialIndex(vertices, faces)
    points = np.array([[0.5, 0.1, z] for z in (2.95, 3.05, 3.15, 2.85)])
    found = find_obstacles(index, points, np.zeros(3), DOWN, lowest=0.1)
    assert found.ground.tolist() == [True, True, False, False]
    assert found.faces[2:].tolist() == [2, 0]


def test_a_point_below_noisy_ground_is_an_obstacle_on_it_but_first_on_what_is_below():
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    vertices = np.concatenate([square, square + np.float32([0, 0, 3])])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.uint32)
    index = SpatialIndex(vertices, faces)
    heights = (2.95, 3.0, 3.05, 2.45, 0.5, 4.2, -0.4, -0.6)
    points = np.array([[0.5, 0.1, z] for z in heights])
    found = find_obstacles(index, points, np.zeros(3), DOWN, lowest=-0.5, highest=1.0)
    assert not found.ground.any()
    assert found.faces.tolist() == [2, 2, 2, NO_FACE, 0, NO_FACE, 0, NO_FACE]
    # An obstacle on the lower floor stays there, however far is looked for ground above.
    found = find_obstacles(index, points, np.zeros(3), DOWN, lowest=-10.0, highest=2.0)
    assert found.faces.tolist() == [2, 2, 2, 2, 0, 2, 0, 0]


@small
def test_obstacles_below_the_ground_equal_brute_force(mesh):
    random = np.random.default_rng(8)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    points = random.uniform(low - 0.4, high + 0.5, (60, 3))
    index = SpatialIndex(mesh.vertices, mesh.faces)
    found = find_obstacles(index, points, low, DOWN, lowest=-0.3, highest=0.6)
    under = faces_below(mesh.vertices, mesh.faces, points, DOWN, 0.6)
    above = faces_below(mesh.vertices, mesh.faces, points, -DOWN, 0.3)
    for face, first, _, close, second, _, close_above in zip(found.faces, *under, *above):
        if not (close or close_above):
            assert face == (first if first != NO_FACE else second)


def random_cloud(random, count, face_count=7):
    faces = random.integers(0, face_count, count).astype(np.uint32)
    return faces, random.uniform(-0.3, 0.3, (count, 3))


def test_marks_equal_a_dictionary():
    random = np.random.default_rng(3)
    marks, expected = ObstacleMarks(7), {}
    for step in range(200):
        faces, points = random_cloud(random, random.integers(0, 30))
        marks.add(faces, points, step)
        cloud = {}
        for face, point in zip(faces, points):
            cube = tuple(np.floor(point / 0.1).astype(int))
            cloud.setdefault((int(face), cube), (tuple(point), float(step)))
        expected.update(cloud)
        kept = random.random(len(marks.times)) < 0.9
        gone = {tuple(point) for point in marks.points[~kept]}
        marks.keep(kept)
        expected = {key: value for key, value in expected.items() if value[0] not in gone}
        if step % 50 == 0:
            marks.set_back(step - 10.0)
            expected = {k: (point, min(t, step - 10.0)) for k, (point, t) in expected.items()}
        held = {tuple(point): time for point, time in zip(marks.points, marks.times)}
        assert held == dict(expected.values())
        assert marks.faces.tolist() == sorted({face for face, _ in expected})
    assert len(expected) > 100 and marks.faces.dtype == np.uint32


def test_marks_of_faces_far_apart_and_far_away():
    marks = ObstacleMarks(2**20)
    faces = np.array([0, 2**20 - 1, 2**20 - 1, 5], np.uint32)
    points = np.array([[0, 0, 0], [1e7, -1e7, 1e300], [1e7, -1e7 - 0.15, 1e300], [0, 0, 0]])
    marks.add(faces, points, 1.0)
    assert marks.faces.tolist() == [0, 5, 2**20 - 1] and len(marks.times) == 4


def test_the_oldest_of_too_many_marks_are_forgotten(monkeypatch):
    monkeypatch.setattr(obstacles, "MOST_MARKS", 50)
    marks = ObstacleMarks(100)
    for step in range(4):
        faces = np.arange(20 * step, 20 * step + 20, dtype=np.uint32)
        marks.add(faces, np.zeros((20, 3)), step)
    assert len(marks.times) == 50 and (marks.times >= 1).all()
    assert marks.faces[10:].tolist() == list(range(40, 80))
