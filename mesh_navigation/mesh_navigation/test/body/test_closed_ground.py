"""Ground that is closed for the middle of a robot with a radius."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_navigation.body.closed_ground import CLOSED, ClosedGround

ROUNDS, CHANGES = 4, 3


def uneven(seed):
    """A floor of 8 m x 8 m with faces of all shapes."""
    random = np.random.default_rng(seed)
    mesh = zoo.grid(cells=40, size=8.0)
    vertices = mesh.vertices.copy()
    vertices[:, :2] += random.uniform(-0.04, 0.04, (len(vertices), 2))
    return MeshGeometry(vertices, mesh.faces)


def distances(points, others):
    return np.linalg.norm(points[:, None] - others, axis=2).min(axis=1)


@pytest.mark.parametrize("seed", range(ROUNDS))
def test_whoever_stays_on_open_ground_keeps_the_radius(seed):
    """Anywhere on edges and faces between open vertices; after changes as from the beginning."""
    random, geometry = np.random.default_rng(seed), uneven(seed)
    radius = random.uniform(0.1, 0.6)
    ground = ClosedGround(geometry, radius)
    count = len(geometry.vertices)
    for _ in range(CHANGES):
        costs = random.uniform(0.0, 1.0, count).astype(np.float32)
        costs[random.integers(count, size=12)] = np.inf
        costs[random.integers(count, size=3)] = np.nan
        found = ground.costs(costs)
        assert found is ground.costs(costs)
        np.testing.assert_array_equal(found, ClosedGround(geometry, radius).costs(costs))
        blocked = ~np.isfinite(costs)
        np.testing.assert_array_equal(~np.isfinite(found), blocked)
        is_open = found <= 1.0
        np.testing.assert_array_equal(found[is_open], costs[is_open])
        assert (found[~is_open & ~blocked] >= CLOSED).all()
        faces = geometry.faces[is_open[geometry.faces].all(axis=1)]
        assert len(faces) > 200
        lethal = geometry.vertices[blocked].astype(np.float64)
        for _ in range(5):
            weights = random.dirichlet([0.5, 0.5, 0.5], len(faces))
            points = np.einsum("fi,fij->fj", weights, geometry.vertices[faces].astype(np.float64))
            assert distances(points, lethal).min() > radius - 0.005
        # Not much more than needed: the edges are 0.2 m long.
        far = distances(geometry.vertices.astype(np.float64), lethal) > radius + 0.2
        assert is_open[far].all()


def test_closed_costs_fall_with_the_distance():
    geometry = uneven(0)
    costs = np.zeros(len(geometry.vertices), np.float32)
    costs[800] = np.inf
    found = ClosedGround(geometry, 1.0).costs(costs)
    closed = np.flatnonzero((found >= CLOSED) & np.isfinite(found))
    near = distances(geometry.vertices[closed], geometry.vertices[[800]])
    order = np.argsort(near)
    assert len(closed) > 50 and (np.diff(found[closed][order]) <= 1e-3 * CLOSED).all()


def test_a_point_asks_for_nothing():
    costs = np.array([0.0, np.inf, np.nan], np.float32)
    assert ClosedGround(None, 0.0).costs(costs) is costs
