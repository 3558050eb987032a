"""What may be passed, and how slow it is there, against plain loops."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_map.geometry import MeshGeometry
from mesh_navigation.slowness import Ground, Grounds, changed_vertices, is_much, passable

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
    ground = Ground(GEOMETRY, costs, limit, factor)
    expected = [np.float32(1 + factor * c) if c <= limit else np.inf for c in costs]
    np.testing.assert_allclose(ground.slowness, expected, rtol=1e-6)
    assert np.array_equal(ground.passable, np.isfinite(expected))
    assert ground.blocked_count == np.isinf(expected).sum()
    faces = np.array([all(ground.passable[list(face)]) for face in MESH.faces])
    if faces.all():
        assert ground.open_faces is None
    else:
        assert np.array_equal(ground.open_faces, faces)
    for array in (ground.slowness, ground.passable):
        assert array.dtype in (np.float32, bool) and not array.flags.writeable


def test_costs_that_are_none():
    costs = np.float32([np.inf, np.nan, -np.inf, -1, 0, 1, 1.0001])
    assert passable(costs, 1.0).tolist() == [False, False, False, True, True, True, False]
    negative = np.full(COUNT, -0.5, np.float32)
    assert Ground(GEOMETRY, negative, 1.0, 10.0).slowness.tolist() == [1.0] * COUNT


def test_grounds_are_shared_while_nothing_changes():
    grounds, costs = Grounds(GEOMETRY), costs_with(0.1)
    first = grounds.of(costs, 1.0, 2.0)
    assert grounds.of(costs, 1.0, 2.0) is first
    others = [grounds.of(costs, 0.5, 2.0), grounds.of(costs, 1.0, 3.0), grounds.of(+costs, 1.0, 2)]
    assert len({id(ground) for ground in [first, *others]}) == 4
    assert others[0].cost_limit == 0.5 and others[1].cost_factor == 3.0


def test_changed_vertices():
    before = Ground(GEOMETRY, costs_with(0.3), 1.0, 1.0).slowness
    after = before.copy()
    after[[3, 50, 7]] = [np.inf, 1.0, 9.0]
    assert changed_vertices(before, before).tolist() == []
    assert changed_vertices(before, before.copy()).tolist() == []
    changed = [v for v in range(COUNT) if before[v] != after[v]]
    assert changed_vertices(before, after).tolist() == changed and 50 in changed
    assert not is_much(np.arange(COUNT // 8), before) and is_much(np.arange(COUNT // 7), before)
