"""Ways down the wave front's potential: every one arrives, on the surface, and is short."""

import gc

import numpy as np
import pytest
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs.outdoor_world import outdoor_world
from meshes import SMALL, TestMesh, data_mesh, real, renumbered, small, terrain
from path_checks import (
    FacePoint,
    Field,
    check_path,
    geometry_of,
    point_in,
    random_points,
    with_noise,
)
from scipy.spatial import Delaunay


@pytest.fixture(scope="module")
def world():
    return outdoor_world(faces=100_000)


@pytest.fixture(scope="module")
def plane():
    corners = np.random.default_rng(0).uniform(0, 10, (3000, 2))
    return MeshGeometry(np.c_[corners, 0 * corners[:, 0]], Delaunay(corners).simplices)


def weighted_length(geometry, slowness, path):
    """The time along a path, with slowness linear in faces."""
    a, b, c = np.moveaxis(geometry.vertices[geometry.faces[path.faces]].astype(float), 1, 0)
    corners = np.nan_to_num(slowness[geometry.faces[path.faces]].astype(float), posinf=0.0)
    normal = np.cross(b - a, c - a)
    square = (normal**2).sum(1)
    middle = 0.5 * (path.points[1:] + path.points[:-1]) - a
    beta = (np.cross(middle, c - a) * normal).sum(1) / square
    gamma = (np.cross(b - a, middle) * normal).sum(1) / square
    slow = (np.stack([1 - beta - gamma, beta, gamma], 1) * corners).sum(1)
    return (slow * np.linalg.norm(np.diff(path.points, axis=0), axis=1)).sum()


@pytest.mark.parametrize(
    "noise, goals", [(0.0, 50), (0.002, 4), (0.005, 4), (0.01, 4), (0.02, 50), (0.05, 4)]
)
def test_every_reachable_pair_on_rough_ground(world, noise, goals):
    geometry = with_noise(world, noise)
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    rng = np.random.default_rng(int(1000 * noise))
    ratios = []
    for goal in random_points(geometry, rng, goals):
        field = solver.solve(goal)
        for start in random_points(geometry, rng, 20):
            path = tracer.path(field, start)
            assert path is not None
            check_path(geometry, field, start, path)
            ratios.append(path.length / path.potentials[0])
    assert len(ratios) == 20 * goals
    off = np.sort(np.abs(np.array(ratios) - 1.0))
    assert off[int(0.99 * (len(off) - 1))] < (0.01 if noise < 0.05 else 0.015)
    assert abs(np.median(ratios) - 1.0) < 0.005


def test_a_way_that_is_cut_off_is_the_beginning_of_the_whole(world):
    geometry = with_noise(world, 0.005)
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    rng = np.random.default_rng(8)
    (goal,) = random_points(geometry, rng, 1)
    field = solver.solve(goal)
    for start in random_points(geometry, rng, 20):
        whole = tracer.path(field, start)
        for length in (0.0, 0.3 * whole.length, 0.6, 2 * whole.length):
            part = tracer.path(field, start, max_length=length)
            assert part.length == pytest.approx(min(length, whole.length))
            kept = len(part.points) - 1
            assert np.array_equal(part.points[:kept], whole.points[:kept])
            assert np.array_equal(part.faces, whole.faces[:kept])
            assert np.array_equal(part.potentials[:kept], whole.potentials[:kept])
    for wrong in (-1.0, np.nan):
        with pytest.raises(ValueError, match="length"):
            tracer.path(field, start, max_length=wrong)


def test_around_closed_ground_and_through_costs(world):
    geometry = with_noise(world, 0.005)
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    rng = np.random.default_rng(3)
    places = geometry.vertices[:, :2]
    slowness = np.ones(len(places), np.float32)
    for center in rng.uniform(places.min(0), places.max(0), (150, 2)):
        away = np.linalg.norm(places - center, axis=1)
        slowness += 4.0 * np.exp(-((away / 3.0) ** 2)) * (rng.random() < 0.5)
        slowness[away < rng.uniform(0.2, 1.5)] = np.inf
    slowness[rng.random(len(places)) < 0.002] = np.nan
    ratios = []
    for goal in random_points(geometry, rng, 5, np.isfinite(slowness)):
        field = solver.solve(goal, slowness=slowness)
        for start in random_points(geometry, rng, 20, np.isfinite(slowness)):
            path = tracer.path(field, start)
            reached = field.reaches(geometry.faces[start.face]).any()
            assert (path is not None) == reached
            if reached:
                check_path(geometry, field, start, path)
                ratios.append(weighted_length(geometry, slowness, path) / path.potentials[0])
    assert len(ratios) > 50
    assert np.percentile(np.abs(np.array(ratios) - 1.0), 90) < 0.02


def test_through_gaps_and_past_lines_of_one_vertex():
    cells = 20
    ticks = np.arange(cells + 1.0)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    faces = np.r_[
        np.c_[corner, corner + cells + 1, corner + 1],
        np.c_[corner + 1, corner + cells + 1, corner + cells + 2],
    ]
    geometry = MeshGeometry(np.c_[x.ravel(), y.ravel(), 0 * x.ravel()], faces)
    slowness = np.ones((cells + 1, cells + 1), np.float32)
    slowness[10, :] = np.inf
    start, goal = FacePoint(0, np.array([0.3, 0.3, 0.0])), point_in(geometry, 700, [0.2, 0.3, 0.5])
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    assert tracer.path(solver.solve(goal, slowness=slowness.ravel()), start) is None
    slowness[10, 14] = slowness[10, 15] = 1.0  # a gap as wide as one edge: in its middle no face
    assert tracer.path(solver.solve(goal, slowness=slowness.ravel()), start) is not None
    field = solver.solve(goal, slowness=slowness.ravel())
    path = tracer.path(field, start)
    check_path(geometry, field, start, path)
    crossing = path.points[np.argmin(np.abs(path.points[:, 0] - 10.0))]
    assert 14.0 <= crossing[1] <= 15.0 and abs(crossing[0] - 10.0) < 1e-9


@small
def test_from_every_face_of_small_meshes(mesh):
    geometry = geometry_of(mesh)
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    rng = np.random.default_rng(1)
    for goal_face in rng.integers(0, len(mesh.faces), 3):
        goal = point_in(geometry, goal_face, rng.dirichlet([1, 1, 1]))
        for field in (solver.solve(goal), solver.solve(int(mesh.faces[goal_face, 0]))):
            for face in range(0, len(mesh.faces), max(1, len(mesh.faces) // 40)):
                start = point_in(geometry, face, rng.dirichlet([1, 1, 1]))
                path = tracer.path(field, start)
                reached = field.reaches(mesh.faces[face]).any()
                assert (path is not None) == reached
                assert np.isfinite(tracer.value(field, start)) == reached
                if reached:
                    check_path(geometry, field, start, path)


@real
def test_on_real_meshes(name):
    geometry = geometry_of(data_mesh(name))
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    rng = np.random.default_rng(1)
    goal, *starts = random_points(geometry, rng, 30)
    field = solver.solve(goal)
    for start in starts:
        path = tracer.path(field, start)
        check_path(geometry, field, start, path)
        assert path.length < 1.02 * path.potentials[0]


def test_straight_on_a_plane(plane):
    tracer, solver = FieldTracer.of(plane), WaveFrontSolver.of(plane)
    rng = np.random.default_rng(1)
    goal, *starts = random_points(plane, rng, 100)
    solved = solver.solve(goal)
    exact = np.linalg.norm(plane.vertices.astype(float) - goal.position, axis=1)
    for field, tolerance in (
        (Field(exact, goal_face=goal.face, goal_position=goal.position), 1e-9),
        (solved, 2e-3),
    ):
        for start in starts:
            path = tracer.path(field, start)
            check_path(plane, field, start, path)
            way = goal.position - start.position
            distance = np.linalg.norm(way)
            aside = np.cross(path.points - start.position, way / distance)
            assert np.linalg.norm(aside, axis=1).max() < tolerance
            assert path.length == pytest.approx(distance, rel=1e-6)
            assert tracer.value(field, start) == pytest.approx(distance, rel=1e-5)


def test_whatever_the_order_of_vertices_and_faces():
    mesh = terrain(60)
    other, new = renumbered(mesh)
    rng = np.random.default_rng(2)
    order = rng.permutation(len(mesh.faces))
    flipped = np.where(rng.random((len(order), 1)) < 0.5, other.faces, other.faces[:, ::-1])
    first, second = geometry_of(mesh), geometry_of(TestMesh("", other.vertices, flipped[order]))
    place = np.argsort(order)
    goal, *starts = random_points(first, rng, 40)
    moved = [FacePoint(int(place[point.face]), point.position) for point in [goal] + starts]
    fields = [WaveFrontSolver.of(first).solve(goal), WaveFrontSolver.of(second).solve(moved[0])]
    gaps = []
    for start, same in zip(starts, moved[1:]):
        path = FieldTracer.of(first).path(fields[0], start)
        again = FieldTracer.of(first).path(fields[0], start)
        assert all(np.array_equal(getattr(path, n), getattr(again, n)) for n in path.__dict__)
        twin = FieldTracer.of(second).path(fields[1], same)
        check_path(second, fields[1], same, twin)
        assert twin.length == pytest.approx(path.length, rel=1e-3)
        at = np.linspace(0.0, 1.0, 100)
        sampled = []
        for way in (path, twin):
            steps = np.linalg.norm(np.diff(way.points, axis=0), axis=1)
            along = np.r_[0.0, np.cumsum(steps)] / way.length
            sampled.append([np.interp(at, along, way.points[:, k]) for k in range(3)])
        gaps.append(np.abs(np.array(sampled[0]) - sampled[1]).max())
    assert np.percentile(gaps, 90) < 0.01  # the rest start where two ways are as long


def test_a_field_that_ends_early_leads_the_same_way(world):
    geometry = with_noise(world, 0.005)
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    rng = np.random.default_rng(5)
    goal, *starts = random_points(geometry, rng, 8)
    whole = solver.solve(goal)
    for start in starts:
        early = solver.solve(goal, targets=geometry.faces[start.face], offset=0.3)
        assert early.limit < np.inf or whole.labels.max() <= early.limit
        path, expected = tracer.path(early, start), tracer.path(whole, start)
        check_path(geometry, early, start, path)
        assert path.length == pytest.approx(expected.length, rel=1e-3)


def test_what_is_not_reached_is_none():
    mesh = next(mesh for mesh in SMALL if mesh.name == "two_components")
    geometry = geometry_of(mesh)
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    field = solver.solve(point_in(geometry, 0, [0.2, 0.3, 0.5]))
    far = point_in(geometry, len(mesh.faces) - 1, [0.2, 0.3, 0.5])
    assert tracer.path(field, far) is None
    assert tracer.value(field, far) == np.inf
    near = solver.solve(point_in(geometry, 0, [0.2, 0.3, 0.5]), max_distance=1.5)
    assert tracer.path(near, point_in(geometry, 0, [0.6, 0.2, 0.2])).faces.tolist() == [0]
    assert tracer.path(near, point_in(geometry, 49, [0.2, 0.3, 0.5])) is None


def test_at_the_goal():
    mesh = terrain(10)
    geometry = geometry_of(mesh)
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    for weights in ([0.2, 0.3, 0.5], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0]):
        goal = point_in(geometry, 50, weights)
        path = tracer.path(solver.solve(goal), goal)
        assert np.array_equal(path.points, goal.position[None])
        assert path.length == 0.0 and path.faces.shape == (0,) and path.potentials.tolist() == [0.0]


def test_cancelled_and_refused(plane):
    tracer, solver = FieldTracer.of(plane), WaveFrontSolver.of(plane)
    goal, start = random_points(plane, np.random.default_rng(1), 2)
    field = solver.solve(goal)
    flag = CancelFlag()
    assert tracer.path(field, start, cancel=flag) is not None
    flag.set()
    with pytest.raises(Canceled):
        tracer.path(field, start, cancel=flag)
    labels = field.labels
    faults = [
        (field, FacePoint(len(plane.faces), start.position), "does not exist"),
        (field, FacePoint(start.face, start.position + [0, 0, 0.1]), "is not on face"),
        (field, FacePoint(start.face, start.position[:2]), "shape"),
        (Field(labels[:-1]), start, "labels"),
        (Field(labels, slowness=np.ones(3, np.float32)), start, "slowness"),
        (Field(labels, goal_face=3, goal_position=goal.position + 50), start, "the goal is not"),
        (Field(labels, goal_face=len(plane.faces), goal_position=goal.position), start, "goal"),
    ]
    for broken, point, message in faults:
        for ask in (tracer.path, tracer.value):
            with pytest.raises(ValueError, match=message):
                ask(broken, point)


def test_one_tracer_for_a_geometry():
    geometry = geometry_of(terrain(5))
    tracer = FieldTracer.of(geometry)
    assert FieldTracer.of(geometry) is tracer
    assert FieldTracer.of(geometry_of(terrain(5))) is not tracer
    goal, start = random_points(geometry, np.random.default_rng(1), 2)
    labels = np.linalg.norm(geometry.vertices.astype(float) - goal.position, axis=1)
    del geometry
    gc.collect()
    field = Field(labels, goal_face=goal.face, goal_position=goal.position)
    assert tracer.path(field, start).potentials[-1] == 0.0
