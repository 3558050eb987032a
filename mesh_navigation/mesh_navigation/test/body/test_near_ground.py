"""Open ground around a place is that of the whole map; ways over it are nowhere too near."""

import numpy as np
import pytest

from mesh_map.distance.obstacle_distance import ObstacleDistance, SurfaceFront
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.spatial.hits import NO_FACE
from mesh_msgs import zoo

from mesh_navigation.body.body import Body
from mesh_navigation.body.closed_ground import CLOSED, ClosedGround
from mesh_navigation.body.near_ground import NearGround
from mesh_navigation.body.robot_shape import RobotShape

RADIUS = 0.25


def rough(seed=0, size=6.0):
    """Ground with corners off by up to half of an edge, and lethal vertices here and there."""
    mesh = zoo.jittered_plane(cells=int(size / 0.1), size=size, seed=seed)
    random = np.random.default_rng(seed)
    vertices = mesh.vertices.copy()
    vertices[:, 2] = random.uniform(-0.05, 0.05, len(vertices))
    costs = np.where(random.random(len(vertices)) < 0.01, np.inf, 0.0).astype(np.float32)
    costs[random.random(len(vertices)) < 0.002] = np.nan
    return MeshGeometry(vertices, mesh.faces), costs


@pytest.mark.parametrize("seed", range(6))
def test_it_is_that_of_the_whole_map(seed):
    geometry, costs = rough(seed)
    whole = ClosedGround(geometry, RADIUS).costs(costs) < CLOSED
    near, random, shares = NearGround(geometry, RADIUS), np.random.default_rng(seed), []
    for _ in range(5):
        place = geometry.vertices[random.integers(len(geometry.vertices))].astype(np.float64)
        reach = random.uniform(0.2, 1.5)
        faces = geometry.spatial_index.in_sphere(center=place, radius=reach)
        asked = np.unique(geometry.faces[faces])
        found = np.isin(asked, near.open_vertices(costs, place, reach))
        np.testing.assert_array_equal(found, whole[asked])
        shares.append(found.mean())
    assert 0.1 < np.mean(shares) < 0.9


@pytest.mark.parametrize("seed", range(3))
def test_least_distances_are_no_more_than_those_along_the_surface(seed):
    """Points become vertices, for which the distances are exact."""
    geometry, costs = rough(seed, 2.5)
    random, place = np.random.default_rng(seed), np.array([1.2, 1.2, 0.0])
    faces = random.permutation(geometry.spatial_index.in_sphere(center=place, radius=0.9))[:150]
    corners = geometry.vertices[geometry.faces[faces]].astype(np.float64)
    weights = random.dirichlet((0.5, 0.5, 0.5), len(faces))
    points = np.einsum("ij,ijk->ik", weights, corners)
    least = NearGround(geometry, RADIUS).least_distances(costs, place, 1.0, points, faces)
    middles = len(geometry.vertices) + np.arange(len(points))
    a, b, c = geometry.faces[faces].astype(np.int64).T
    parts = [np.stack(part, axis=1) for part in ((a, b, middles), (b, c, middles), (c, a, middles))]
    others = np.delete(geometry.faces.astype(np.int64), faces, axis=0)
    cut = MeshGeometry(
        np.concatenate([geometry.vertices, points.astype(np.float32)]),
        np.concatenate([others, *parts]).astype(np.uint32),
    )
    distance = ObstacleDistance(front=SurfaceFront.of(cut), max_distance=1.0)
    distance.compute(np.append(~np.isfinite(costs), np.zeros(len(points), bool)))
    exact = distance.distances()[middles]
    assert (least <= exact + 1e-5).all() and (least <= RADIUS).all()
    assert (least == RADIUS).sum() > 10 and (least < 0.5 * RADIUS).any()
    nowhere = np.full(len(points), NO_FACE)
    found = NearGround(geometry, RADIUS).least_distances(costs, place, 1.0, points, nowhere)
    assert (found == -np.inf).all()


def test_it_follows_costs_and_places():
    geometry, costs = rough()
    near, place = NearGround(geometry, RADIUS), np.array([3.0, 3.0, 0.0])
    first = near.open_vertices(costs, place, 0.5)
    assert near.open_vertices(costs, place + [0.3, 0.0, 0.0], 0.5) is first
    assert near.open_vertices(costs, place + [0.6, 0.0, 0.0], 0.5) is not first
    assert len(near.open_vertices(np.full_like(costs, np.inf), place, 0.5)) == 0
    everywhere = near.open_vertices(np.zeros_like(costs), place, 0.5)
    faces = geometry.spatial_index.in_sphere(center=place, radius=0.5)
    assert np.isin(geometry.faces[faces], everywhere).all()


def test_a_way_over_open_faces_is_not_too_near_to_what_is_near_through_space():
    """A sheet 0.1 m above the ground, of another part with a lethal rim; a lethal vertex of the
    ground."""
    ground, sheet = zoo.grid(cells=20, size=2.0), zoo.grid(cells=4, size=0.4)
    count = len(ground.vertices)
    above = sheet.vertices + np.float32([0.8, 0.2, 0.1])
    geometry = MeshGeometry(
        np.concatenate([ground.vertices, above]),
        np.concatenate([ground.faces, sheet.faces + count]),
    )
    costs = np.zeros(count + len(above), np.float32)
    costs[count:] = np.inf
    costs[count + 12] = 0.0  # its middle
    body = Body(geometry, RobotShape(radius=RADIUS))

    def first_near(y):
        walk = geometry.walker.walk(
            start=geometry.closest_face((0.31, y, 0.0), max_distance=0.05),
            direction=(1.0, 0.0, 0.0),
            length=1.0,
            path=True,
        )
        near = body.obstacles(costs, np.array([0.31, y, 0.0]), 1.0)
        assert near.distances(walk.path.points).min() < 0.5 * RADIUS
        return near.first_near(walk.path.points, walk.path.faces)

    assert first_near(0.41) is None
    post = np.argmin(np.linalg.norm(geometry.vertices[:count] - [1.0, 1.5, 0.0], axis=1))
    costs = costs.copy()
    costs[post] = np.inf
    assert first_near(0.41) is None
    assert first_near(1.41) == pytest.approx(1.0 - 0.31 - RADIUS, abs=0.08)
