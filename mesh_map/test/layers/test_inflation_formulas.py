"""The inflation layer: its distances over the surface, and what becomes of them.

Distances are read from costs: fading is monotone, so that it can be turned around.
"""

import numpy as np
import pytest
from layer_calls import evaluated, scaled
from layer_oracles import OracleMesh, distance_on_plane, fading, surface_distance
from meshes import BOTANICAL, SMALL, TRAY, TestMesh

EVERY = [mesh.name for mesh in SMALL] + [TRAY, BOTANICAL]
PLANES = ("grid", "jittered_plane", "hole", "two_components")
REACH = 3.0  # the largest inflation_radius that both releases allow
LEAST = 0.01  # and the least inscribed_radius

# The way of a front over triangles is not exact. Bounds of the relative error of distances up to
# NEAR, that of the oracle included, which is too long by up to 0.7 %: all but a hundredth, on both
# sides, and the mean. The three in LOOSE bend strongly from face to face, and there distances are
# known to come out short (README, limits): these bounds hold what there is, not what is wanted. The
# garden consists of leaves, hardly two faces of which lie in one plane.
NEAR = 1.0  # meters, five edges of the small meshes
BOUNDS = (0.1, 0.05, 0.02)  # too short, too long, mean
LOOSE = {
    "torus": (0.15, 0.05, 0.02),
    "terrain": (0.15, 0.05, 0.025),
    BOTANICAL: (0.35, 0.1, 0.05),
}


def distances(mesh, lethal):
    """(V,) meters from lethal vertices as the layer has them; +inf from REACH on, 0 up to LEAST."""
    costs = evaluated(
        "Inflation",
        mesh,
        lethal=lethal,
        inscribed_radius=LEAST,
        inflation_radius=REACH,
        inscribed_value=1.0,
        lethal_value=-1.0,
    ).costs.astype(np.float64)
    between = LEAST + (REACH - LEAST) * np.arccos(np.clip(2 * costs - 1, -1, 1)) / np.pi
    return np.where(np.isinf(costs) | (costs == 1), 0.0, np.where(costs > 0, between, np.inf))


def some_vertices(oracle, share, seed=0):
    random = np.random.default_rng(seed)
    used = np.unique(oracle.faces)
    return random.choice(used, max(1, int(share * len(used))), replace=False)


@pytest.mark.parametrize("name", EVERY + ["terrain"])
@pytest.mark.parametrize("share", [0.002, 0.05])
def test_distances_over_the_surface(name, share):
    mesh, oracle = scaled(name)
    lethal = some_vertices(oracle, share)
    found = distances(mesh, lethal)
    expected = surface_distance(oracle, lethal, 5 if name == BOTANICAL else 9)
    assert np.isinf(found[np.isinf(expected)]).all()  # of other components
    near = (expected < NEAR) & (expected > 5 * LEAST)
    assert np.isfinite(found[near]).all()
    ratio = found[near] / expected[near]
    too_short, too_long, mean = LOOSE.get(name, BOUNDS)
    if len(ratio):
        low, high = np.percentile(ratio, (1, 99))
        assert low > 1 - too_short and high < 1 + too_long, (low, high)
        assert abs(ratio.mean() - 1) < mean, ratio.mean()


# The obstacle is a point beyond the first face; the way to the vertex 1 is straight, and crosses an
# edge of which one end, or both, are farther from the obstacle than that vertex.
OBTUSE = {
    "nearer than both": [[-1, -0.2, 0], [0, 0, 0], [1.5, -0.2, 0], [-0.2, -0.9, 0]],
    "nearer than one": [[-0.83, -0.8, 0], [0, 0, 0], [0.8, 0.9, 0], [-0.5, 0.5, 0]],
    "folded": [[-0.8, -0.8, -0.1], [0, 0, 0], [0.8, 0.9, 0.4], [-0.6, 0.5, 0.4]],
}


@pytest.mark.parametrize("name", OBTUSE)
def test_a_way_across_an_obtuse_triangle(name):
    points = np.array(OBTUSE[name], np.float32)
    facing = [[0, 2, 1], [0, 3, 2]] if name == "nearer than both" else [[0, 1, 2], [0, 2, 3]]
    mesh = TestMesh(name, points, np.array(facing, np.uint32))
    expected = surface_distance(OracleMesh(mesh), [3], 60)
    np.testing.assert_allclose(distances(mesh, [3])[1], expected[1], rtol=0.02)


@pytest.mark.parametrize("name", EVERY)
def test_distances_of_neighbors_differ_by_no_more_than_the_edge(name):
    mesh, oracle = scaled(name)
    found = distances(mesh, some_vertices(oracle, 0.01))
    known = np.where(found > 0.95 * REACH, np.nan, found)  # the cosine is flat there
    step = np.abs(np.diff(known[oracle.edges], axis=1))[:, 0]
    assert not (step > oracle.lengths * (1 + 1e-4) + 1.1 * LEAST).any()


@pytest.mark.parametrize("name", PLANES)
@pytest.mark.parametrize("seed", range(3))
def test_distances_on_a_plane_are_euclidean(name, seed):
    """As the crow flies, where it can: not around holes, which have ways around them."""
    mesh, oracle = scaled(name)
    lethal = some_vertices(oracle, 0.04, seed)
    found = distances(mesh, lethal)
    euclidean = distance_on_plane(oracle, lethal)
    shown = (found < 0.9 * REACH) & (euclidean > 5 * LEAST)
    assert (found[shown] > euclidean[shown] * (1 - 1e-3)).all()
    if name in ("grid", "jittered_plane"):
        assert (found[shown] < euclidean[shown] * (1 + 5e-3)).all()


def test_distances_from_a_wall():
    """A straight line of lethal vertices is a line, not the points between which it runs."""
    mesh, oracle = scaled("grid")
    x = oracle.points[:, 0]
    found = distances(mesh, np.flatnonzero(x == 0))
    shown = (found < 0.9 * REACH) & (x > 0)
    assert shown.sum() > 50
    np.testing.assert_allclose(found[shown], x[shown], rtol=2e-4)


@pytest.mark.parametrize("name", ["jittered_plane", "torus", TRAY])
@pytest.mark.parametrize(
    "inscribed, inflated, value, lethal_value, scale",
    [
        (0.25, 0.4, 1.0, 2.0, None),  # as released
        (0.15, 0.25, 0.4, 1.0, None),  # botanical garden
        (0.3, 1.0, 4.0, 6.0, None),  # stone quarry
        (1.0, 1.0, 0.4, 1.0, None),  # market garden: no ring
        (1.0, 0.4, 0.4, 1.0, None),
        (0.25, 1.5, 1.0, -1.0, None),
        (0.4, 1.5, 1.0, -1.0, 2.0),
        (0.25, 0.4, 0.99, 1.0, 1.0),
    ],
)
def test_fading(name, inscribed, inflated, value, lethal_value, scale):
    mesh, oracle = scaled(name)
    lethal = some_vertices(oracle, 0.02)
    distance = distances(mesh, lethal)
    variant = {} if scale is None else {"fading": "exponential", "cost_scaling_factor": scale}
    result = evaluated(
        "Inflation",
        mesh,
        lethal=lethal,
        inscribed_radius=inscribed,
        inflation_radius=inflated,
        inscribed_value=value,
        lethal_value=lethal_value,
        **variant,
    )
    expected = fading(distance, inscribed, inflated, value, lethal_value, scale)
    # distances out of costs are uncertain near both ends
    edge = np.minimum(np.abs(distance - inscribed), np.abs(distance - inflated)) < 1e-4
    sure = ~edge & ((distance == 0) | (distance > 3 * LEAST))
    np.testing.assert_allclose(result.costs[sure], expected[sure], rtol=1e-4, atol=2e-4)
    assert np.array_equal(np.flatnonzero(result.lethal), np.sort(lethal))


def test_costs_fall_with_the_distance():
    mesh, oracle = scaled("jittered_plane")
    lethal = some_vertices(oracle, 0.02)
    order = np.argsort(distance_on_plane(oracle, lethal))
    for fade in ("cosine", "exponential"):
        costs = evaluated(
            "Inflation", mesh, lethal=lethal, inflation_radius=0.8, fading=fade
        ).costs[order]
        assert (np.diff(costs) <= 2e-3).all() and costs[0] == 2.0 and costs[-1] == 0.0


def test_a_lonely_lethal_vertex_inflates_and_one_without_faces_harms_nobody():
    mesh, oracle = scaled("isolated_vertex")
    used = np.unique(oracle.faces)
    alone = np.setdiff1d(np.arange(oracle.count), used)
    result = evaluated("Inflation", mesh, lethal=alone)
    assert np.array_equal(np.flatnonzero(result.lethal), alone) and not result.costs[used].any()
    one = evaluated("Inflation", mesh, lethal=used[:1], inflation_radius=1.0).costs
    assert (one[used] > 0).sum() > 3 and not one[alone].any()


@pytest.mark.parametrize("name", ["jittered_plane", "tetrahedron", "soup_6"])
def test_all_or_nothing_lethal(name):
    mesh, oracle = scaled(name)
    nothing = evaluated("Inflation", mesh, lethal=[])
    assert not nothing.costs.any() and not nothing.lethal.any()
    everything = evaluated("Inflation", mesh, lethal=np.arange(oracle.count), lethal_value=7.0)
    assert (everything.costs == 7).all() and everything.lethal.all()


def test_repulsive_vectors_point_away():
    mesh, oracle = scaled("grid")
    x = oracle.points[:, 0]
    lethal = np.flatnonzero(x == 0)
    result = evaluated("Inflation", mesh, lethal=lethal, inflation_radius=0.7)
    near = (x > 0) & (x < 0.65)
    vectors = result.vectors[near].astype(np.float64)
    lengths = np.linalg.norm(vectors, axis=1)
    assert (lengths > 0).all() and not result.vectors[x > 0.75].any()
    assert (vectors[:, 0] > 0.95 * lengths).all()
    without = evaluated("Inflation", mesh, lethal=lethal, repulsive_field=False)
    assert without.vectors is None or not without.vectors.any()
