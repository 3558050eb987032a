"""Directions down a potential at vertices and faces: unit vectors in the surface, and downwards."""

import numpy as np
import pytest
from mesh_map.distance.obstacle_distance import SurfaceFront
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs import zoo
from meshes import small, terrain
from path_checks import FacePoint, Field, geometry_of, point_in, random_points


def lengths(directions):
    return np.linalg.norm(directions.astype(np.float64), axis=1)


def exact_field(geometry, goal):
    labels = np.linalg.norm(geometry.vertices.astype(float) - goal.position, axis=1)
    return Field(labels, goal_face=goal.face, goal_position=goal.position)


@pytest.mark.parametrize("weights", [[0.2, 0.3, 0.5], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0]])
@pytest.mark.parametrize("slow", [None, 3.0])
def test_to_the_goal_on_a_plane(weights, slow):
    mesh = zoo.jittered_plane(cells=20)
    geometry = MeshGeometry(mesh.vertices, mesh.faces)
    goal = point_in(geometry, 337, weights)
    field = exact_field(geometry, goal)
    if slow is not None:
        slowness = np.full(len(mesh.vertices), slow, np.float32)
        field = field._replace(labels=slow * field.labels, slowness=slowness)
    tracer = FieldTracer.of(geometry)
    middles = mesh.vertices[mesh.faces].astype(float).mean(1)
    for at, found in (
        (mesh.vertices.astype(float), tracer.vertex_directions(field)),
        (middles, tracer.face_directions(field)),
    ):
        way = goal.position - at
        distance = np.linalg.norm(way, axis=1, keepdims=True)
        assert found.dtype == np.float32 and found.shape == at.shape
        away = distance[:, 0] > 1e-6
        assert np.abs(found - way / np.maximum(distance, 1e-9))[away].max() < 1e-5
        assert (found[~away] == 0.0).all()


@small
def test_in_the_surface_or_zero(mesh):
    geometry = geometry_of(mesh)
    tracer = FieldTracer.of(geometry)
    field = WaveFrontSolver.of(geometry).solve(point_in(geometry, 0, [0.2, 0.3, 0.5]))
    reached = field.reaches(np.arange(len(mesh.vertices)))
    at_vertices, at_faces = tracer.vertex_directions(field), tracer.face_directions(field)
    for directions, normals, is_reached in (
        (at_vertices, geometry.vertex_normals, reached),
        (at_faces, geometry.face_normals, reached[mesh.faces].all(axis=1)),
    ):
        length = lengths(directions)
        assert (np.abs(length[length > 0.0] - 1.0) < 1e-6).all()
        assert (length[~is_reached] == 0.0).all()
        thick = np.abs((directions * normals).sum(1)) < 1e-4
        assert thick[~geometry.faces_without_area].all() if directions is at_faces else thick.all()
    corners = mesh.vertices[mesh.faces].astype(float)
    area = lengths(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    some = lengths(at_faces) > 0.0
    assert some[reached[mesh.faces].all(axis=1) & (area > 1e-4)].all()


def test_downwards_where_paths_go():
    geometry = geometry_of(terrain(50))
    tracer = FieldTracer.of(geometry)
    rng = np.random.default_rng(4)
    (goal,) = random_points(geometry, rng, 1)
    field = WaveFrontSolver.of(geometry).solve(goal)
    at_vertices, at_faces = tracer.vertex_directions(field), tracer.face_directions(field)
    same = []
    for v in rng.choice(len(geometry.vertices), 300, replace=False):
        face = geometry.topology.vertex_faces[geometry.topology.vertex_face_offsets[v]]
        path = tracer.path(field, FacePoint(int(face), geometry.vertices[v].astype(float)))
        normal = geometry.vertex_normals[v].astype(float)
        step = path.points[1] - path.points[0]
        step -= normal * (step @ normal)
        same.append(at_vertices[v] @ step / np.linalg.norm(step))
    assert np.percentile(same, 5) > 0.99
    falls = []
    for face in rng.choice(len(geometry.faces), 300, replace=False):
        here = point_in(geometry, face, np.full(3, 1 / 3))
        there = FacePoint(here.face, here.position + 1e-3 * at_faces[face])
        falls.append((tracer.value(field, here) - tracer.value(field, there)) / 1e-3)
    assert np.percentile(falls, 5) > 0.95 and np.median(falls) == pytest.approx(1.0, abs=0.01)


def test_zero_beyond_what_is_known():
    geometry = geometry_of(terrain(30))
    tracer, solver = FieldTracer.of(geometry), WaveFrontSolver.of(geometry)
    rng = np.random.default_rng(1)
    goal = point_in(geometry, 600, [0.2, 0.3, 0.5])
    slowness = np.ones(900, np.float32)
    slowness[rng.choice(900, 40, replace=False)] = np.inf
    slowness[geometry.faces[600]] = 1.0
    field = solver.solve(goal, slowness=slowness, max_distance=1.0)
    known = field.reaches(np.arange(900))
    assert 50 < known.sum() < 500
    found = lengths(tracer.vertex_directions(field))
    assert (found[~known] == 0.0).all() and (found[known] > 0.9).all()
    at_faces = lengths(tracer.face_directions(field)) > 0.9
    assert np.array_equal(at_faces, known[geometry.faces].all(axis=1))


def test_any_number_of_threads_gives_the_same():
    geometry = geometry_of(terrain(100))
    tracer = FieldTracer.of(geometry)
    field = WaveFrontSolver.of(geometry).solve(point_in(geometry, 9000, [0.2, 0.3, 0.5]))
    kernel, normals = tracer.kernel, tracer._normals
    bound = kernel._bind(field.labels, field.limit, None, field.goal_face, field.goal_position)
    front = SurfaceFront.of(geometry)._mesh
    assert np.array_equal(
        kernel._vertex_directions(bound, front, normals, threads=1),
        tracer.vertex_directions(field),
    )
    assert np.array_equal(kernel._face_directions(bound, threads=1), tracer.face_directions(field))


def test_refuses_the_field_of_another_mesh():
    tracer = FieldTracer.of(geometry_of(terrain(5)))
    for ask in (tracer.vertex_directions, tracer.face_directions):
        with pytest.raises(ValueError, match="labels"):
            ask(Field(np.zeros(24)))
