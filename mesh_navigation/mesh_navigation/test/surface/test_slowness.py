"""What may be passed, and how slow it is there, against plain loops."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_navigation.surface.slowness import (
    CostSnapshot,
    CostSnapshots,
    changed_vertices,
    is_much,
    passable,
)

MESH = zoo.jittered_plane()
GEOMETRY = MeshGeometry(MESH.vertices, MESH.faces)
COUNT = len(MESH.vertices)


def costs_with(share, seed=0):
    """Random costs; of this share a third each is lethal, unknown or high."""
    rng = np.random.default_rng(seed)
    costs = rng.uniform(0, 1, COUNT).astype(np.float32)
    odd = rng.permutation(COUNT)[: int(share * COUNT)]
    costs[odd] = np.resize(np.float32([np.inf, np.nan, 7.0]), len(odd))
    return costs


@pytest.mark.parametrize("limit", [0.0, 0.5, 1.0, 10.0])
@pytest.mark.parametrize("factor", [0.0, 1.0, 100.0])
@pytest.mark.parametrize("share", [0.0, 0.03, 0.5, 1.0])
def test_ground(limit, factor, share):
    costs = costs_with(share)
    ground = CostSnapshot(GEOMETRY, costs, limit, factor)
    expected = [np.float32(1 + factor * c) if c <= limit else np.inf for c in costs]
    if np.all(np.equal(expected, 1)):
        assert ground.slowness is None
    else:
        np.testing.assert_allclose(ground.slowness, expected, rtol=1e-6)
        assert ground.slowness.dtype == np.float32 and not ground.slowness.flags.writeable
    assert np.array_equal(ground.passable, np.isfinite(expected))
    assert ground.blocked_count == np.isinf(expected).sum()
    faces = np.array([all(ground.passable[list(face)]) for face in MESH.faces])
    if faces.all():
        assert ground.open_faces is None
    else:
        assert np.array_equal(ground.open_faces, faces)
    assert ground.passable.dtype == bool and not ground.passable.flags.writeable


def test_costs_that_are_none():
    costs = np.float32([np.inf, np.nan, -np.inf, -1, 0, 1, 1.0001])
    assert passable(costs, 1.0).tolist() == [False, False, False, True, True, True, False]
    negative = np.full(COUNT, -0.5, np.float32)
    assert CostSnapshot(GEOMETRY, negative, 1.0, 10.0).slowness is None
    negative[3] = np.nan
    slowness = CostSnapshot(GEOMETRY, negative, 1.0, 10.0).slowness
    assert slowness.tolist() == [np.inf if v == 3 else 1.0 for v in range(COUNT)]


def test_grounds_are_shared_while_nothing_changes():
    snapshots, costs = CostSnapshots(GEOMETRY), costs_with(0.1)
    first = snapshots.of(costs, 1.0, 2.0)
    assert snapshots.of(costs, 1.0, 2.0) is first
    others = [
        snapshots.of(costs, 0.5, 2.0),
        snapshots.of(costs, 1.0, 3.0),
        snapshots.of(+costs, 1.0, 2),
    ]
    assert len({id(ground) for ground in [first, *others]}) == 4
    assert others[0].cost_limit == 0.5 and others[1].cost_factor == 3.0


def test_changed_vertices():
    costs = costs_with(0.3)
    other = costs.copy()
    other[[3, 50, 7]] = [np.inf, 0.0, 0.9]
    before, after, same = (
        CostSnapshot(GEOMETRY, c, 1.0, 1.0) for c in (costs, other, costs.copy())
    )
    for ground in (before, same):
        assert changed_vertices(before, ground).tolist() == []
    changed = [v for v in range(COUNT) if before.slowness[v] != after.slowness[v]]
    assert changed_vertices(before, after).tolist() == changed and 50 in changed


def test_changed_vertices_where_some_or_all_are_plain():
    free = CostSnapshot(GEOMETRY, costs_with(0.0), 1.0, 0.0)
    blocked = CostSnapshot(GEOMETRY, costs_with(0.1), 1.0, 0.0)
    assert free.slowness is None and blocked.slowness is not None
    assert (
        changed_vertices(free, CostSnapshot(GEOMETRY, costs_with(0.0, 1), 1.0, 0.0)).tolist() == []
    )
    closed = np.flatnonzero(~blocked.passable).tolist()
    assert len(closed) > 10
    for pair in ((free, blocked), (blocked, free)):
        assert changed_vertices(*pair).tolist() == closed


def test_is_much():
    ground = CostSnapshot(GEOMETRY, costs_with(0.0), 1.0, 0.0)
    assert not is_much(np.arange(COUNT // 8), ground) and is_much(np.arange(COUNT // 7), ground)
