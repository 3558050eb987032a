"""Fronts from Python: seeds, limits, cancelling, and one front for a geometry."""

import gc

import numpy as np
import pytest
from meshes import small, terrain
from mesh_map import MeshMap
from mesh_map.cancel import CancelFlag
from mesh_map.errors import Cancelled
from mesh_map.front import ObstacleDistance, SurfaceFront
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra


@pytest.fixture(scope="module")
def front():
    mesh = terrain()
    return SurfaceFront.of(MeshMap(mesh.vertices, mesh.faces).geometry)


def test_one_front_for_a_geometry():
    mesh = terrain(10)
    geometry = MeshMap(mesh.vertices, mesh.faces).geometry
    front = SurfaceFront.of(geometry)
    assert SurfaceFront.of(geometry) is front
    other = SurfaceFront.of(MeshMap(mesh.vertices, mesh.faces).geometry)
    assert other is not front
    del geometry
    gc.collect()
    assert np.isfinite(front.distance_from(0).distances).all()


@small
def test_lies_between_straight_lines_and_edges(mesh):
    geometry = MeshMap(mesh.vertices, mesh.faces).geometry
    found = SurfaceFront.of(geometry).distance_from(int(mesh.faces[0, 0])).distances
    points, edges = mesh.vertices.astype(np.float64), geometry.topology.edges
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    graph = coo_matrix((np.maximum(lengths, 1e-30), edges.T.astype(int)), (len(points),) * 2)
    over_edges = dijkstra(graph, directed=False, indices=int(mesh.faces[0, 0]))
    straight = np.linalg.norm(points - points[mesh.faces[0, 0]], axis=1)
    reached = np.isfinite(over_edges)
    assert np.array_equal(np.isfinite(found), reached)
    scale = 1e-5 * (1 + np.abs(points).max())
    assert (found[reached] <= over_edges[reached] * (1 + 1e-5) + scale).all()
    assert (found[reached] >= 0.9 * straight[reached] - scale).all()


def test_seeds_of_all_kinds(front):
    one = front.distance_from(5).distances
    assert one[5] == 0 and (one[:5] > 0).all()
    assert np.array_equal(front.distance_from([5]).distances, one)
    assert np.array_equal(front.distance_from([(5, 0.0)]).distances, one)
    assert np.array_equal(front.distance_from(np.array([5])).distances, one)
    assert front.distance_from([(5, 2.0)]).distances.min() == 2
    several = front.distance_from([5, 900]).distances
    assert np.abs(several - np.minimum(one, front.distance_from(900).distances)).max() < 0.05
    near = front.distance_from(5, max_distance=0.5).distances
    assert np.array_equal(near, np.where(one <= 0.5, one, np.inf))


def test_slowness_closes_and_slows(front):
    slow = np.full(1600, 2.0)
    plain, found = front.distance_from(7).distances, front.distance_from(7, slowness=slow).distances
    assert np.allclose(found, 2 * plain, rtol=1e-4)
    slow[800:840] = np.inf
    slow[820] = np.nan
    closed = front.distance_from(7, slowness=slow).distances
    assert np.isinf(closed[800:]).all() and np.isfinite(closed[:800]).all()


@pytest.mark.parametrize(
    "arguments, message",
    [
        (dict(seeds=1600), "seed vertex 1600 does not exist: there are 1600 vertices"),
        (dict(seeds=-1), "seed vertex -1 does not exist"),
        (dict(seeds=[]), "there is no seed"),
        (dict(seeds=[(3, -1.0)]), "the distance of source 0 has to be finite and 0 or more"),
        (dict(seeds=3, max_distance=-1.0), "the maximum distance has to be 0 or more"),
        (dict(seeds=3, slowness=[1.0]), "slowness has to have the shape"),
        (dict(seeds=3, slowness=np.full(1600, -1.0)), "the slowness of vertex 0 is negative"),
        (dict(seeds=3, cancel=True), "cancel has to be"),
    ],
)
def test_what_does_not_fit_is_refused(front, arguments, message):
    with pytest.raises(ValueError, match=message):
        front.distance_from(**arguments)


def test_obstacles_are_refused_and_cancelled(front):
    with pytest.raises(ValueError, match="the maximum distance has to be above 0"):
        ObstacleDistance(front=front, max_distance=0.0)
    with pytest.raises(ValueError, match="lethal has the shape"):
        front.distance_to_obstacles(np.zeros(3, bool), 1.0)
    flag = CancelFlag()
    flag.set()
    assert front.distance_from(0, cancel=flag).cancelled


def test_a_cancelled_run_is_an_error():
    mesh = terrain(150)
    front = SurfaceFront.of(MeshMap(mesh.vertices, mesh.faces).geometry)
    flag = CancelFlag()
    flag.set()
    lethal = np.arange(150 * 150) % 97 == 0
    with pytest.raises(Cancelled):
        front.distance_to_obstacles(lethal, 5.0, flag)
    assert np.isfinite(front.distance_to_obstacles(lethal, 5.0)).all()
