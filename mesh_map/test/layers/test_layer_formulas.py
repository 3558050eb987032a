"""Costs of the layers that measure the geometry, against formulas in plain NumPy."""

import layer_oracles
import numpy as np
import pytest
from layer_calls import evaluated, scaled
from meshes import BOTANICAL, SMALL, TRAY, TestMesh, data_mesh

EVERY = [mesh.name for mesh in SMALL] + [TRAY, BOTANICAL]
every = pytest.mark.parametrize("name", EVERY)
STATISTICS = (
    ("HeightDiff", layer_oracles.height_difference),
    ("Roughness", layer_oracles.roughness),
)
statistics = pytest.mark.parametrize("kind, formula", STATISTICS, ids=[k for k, _ in STATISTICS])
# Of height differences: between vertices alone, as the formula has it (see test_radius_pass.py).
VERTICES = {"HeightDiff": {"large_faces": False}}
radii = pytest.mark.parametrize("radius", [0.3, 0.45])

# Rounding of a normal to 32 bits turns it by 1e-7, which an angle of 0 shows as its root.
ANGLE = 1e-3


def sure_vertices(mesh, radius=None):
    """(V,) bool: no normal within the radius (of neighbors, too) is but rounding that is left."""
    doubtful = mesh.normals[1] < 1e-4
    for a, b in (mesh.edges.T, mesh.edges.T[::-1]):
        doubtful = doubtful | (np.bincount(a, mesh.normals[1][b] < 1e-4, mesh.count) > 0)
    if radius is not None:
        center, reached = mesh.neighborhoods(radius)
        doubtful = doubtful | (np.bincount(center, doubtful[reached], mesh.count) > 0)
    return ~doubtful


def near_radius(name, radius):
    """0.45 m are thousands of vertices on the finest mesh."""
    return 0.1 if name == BOTANICAL and radius > 0.3 else radius


def check_statistic(kind, oracle, result, expected, radius):
    assert result.costs.dtype == np.float32
    assert np.array_equal(np.isnan(result.costs), np.isnan(expected))
    assert not np.isinf(result.costs).any()
    if kind == "HeightDiff":
        assert np.array_equal(result.costs, expected.astype(np.float32), equal_nan=True)
    else:
        sure = sure_vertices(oracle, radius)
        assert sure.mean() > 0.5 or len(sure) < 30
        tolerance = ANGLE if kind == "Roughness" else 2e-6
        np.testing.assert_allclose(result.costs[sure], expected[sure], rtol=1e-5, atol=tolerance)
    assert np.array_equal(result.lethal, result.costs > layer_threshold(kind))


@every
@radii
@pytest.mark.parametrize("include_vertex", [False, True])
@statistics
def test_statistics_within_a_radius(name, radius, include_vertex, kind, formula):
    radius = near_radius(name, radius)
    mesh, oracle = scaled(name)
    params = dict(VERTICES.get(kind, {}), include_vertex=include_vertex)
    result = evaluated(kind, mesh, radius=radius, **params)
    check_statistic(kind, oracle, result, formula(oracle, radius, include_vertex), radius)


@every
@radii
def test_ridge_within_a_radius(name, radius):
    radius = near_radius(name, radius)
    mesh, oracle = scaled(name)
    result = evaluated("Ridge", mesh, radius=radius)
    check_statistic("Ridge", oracle, result, layer_oracles.ridge(oracle, radius), radius)


@every
@statistics
def test_whether_the_vertex_counts_where_nothing_is_said(name, kind, formula):
    """Not for roughness, as released; for height differences, which a lone vertex has not."""
    mesh, _ = scaled(name)
    result = evaluated(kind, mesh)
    same = evaluated(kind, mesh, include_vertex=kind == "HeightDiff")
    assert np.array_equal(result.costs, same.costs) and np.array_equal(result.lethal, same.lethal)


def layer_threshold(kind):
    return np.float32({"HeightDiff": 0.185}.get(kind, 0.3))


@every
def test_steepness(name):
    mesh, oracle = scaled(name)
    result = evaluated("Steepness", mesh)
    sure = oracle.normals[1] > 1e-4
    expected = layer_oracles.steepness(oracle)
    np.testing.assert_allclose(result.costs[sure], expected[sure], atol=ANGLE)
    assert np.array_equal(result.lethal, result.costs > layer_threshold("Steepness"))


@every
def test_border(name):
    mesh, oracle = scaled(name)
    result = evaluated("Border", mesh, border_cost=0.7)
    expected = layer_oracles.border(oracle, 0.7).astype(np.float32)
    assert np.array_equal(result.costs, expected)
    assert np.array_equal(result.lethal, expected > 0)
    assert not evaluated("Border", mesh, border_cost=0.7, threshold=0.7).lethal.any()


@every
def test_clearance(name):
    mesh, oracle = scaled(name)
    some = np.arange(0, oracle.count, max(oracle.count // 150, 1))
    result = evaluated("Clearance", mesh, robot_height=0.4, height_inflation=0.5)
    normals, size = oracle.normals
    lift = np.maximum(1e-3, 4 * np.spacing(np.abs(mesh.vertices[some]).max(axis=1)))
    start = oracle.points[some] + lift[:, None] * normals[some]
    # a ray near an edge may pass by it: the cost has to lie between those of hit and miss
    free = lift + layer_oracles.free_distances(oracle, start, normals[some], (1e-4, -1e-4))
    costs = layer_oracles.clearance_cost(free, 0.4, 0.5)
    sure = size[some] > 1e-4
    low, high = np.min(costs, 0)[sure] - 2e-4, np.max(costs, 0)[sure] + 2e-4
    found = result.costs[some][sure]
    assert ((low <= found) & (found <= high)).all()
    assert np.array_equal(result.lethal, result.costs == 1)
    assert name not in (TRAY, BOTANICAL) or (high - low < 1e-3).mean() > 0.9


def test_clearance_under_a_ceiling():
    """Two squares, the upper one tilted: from 0.2 m of room on one side to 1.2 m on the other."""
    size = 21
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, size), np.linspace(0, 1, size)))
    floor = np.stack([x, y, 0 * x], 1)
    corner = np.arange(size * size).reshape(size, size)[:-1, :-1].ravel()
    sides = np.stack([corner, corner + 1, corner + size + 1], 1)
    faces = np.concatenate([sides, np.stack([corner, corner + size + 1, corner + size], 1)])
    ceiling = np.array([[-1, -1, -0.8], [3, -1, 3.2], [3, 3, 3.2], [-1, 3, -0.8]])
    top = np.array([[0, 1, 2], [0, 2, 3]]) + len(floor)
    mesh = TestMesh("room", np.concatenate([floor, ceiling]), np.concatenate([faces, top]))
    result = evaluated("Clearance", mesh, robot_height=0.5, height_inflation=0.3)
    expected = layer_oracles.clearance_cost(0.2 + x, 0.5, 0.3)
    sure = np.abs(x - 0.3) > 1e-6
    np.testing.assert_allclose(result.costs[: len(floor)][sure], expected[sure], atol=1e-5)
    assert result.lethal[: len(floor)][x < 0.29].all()
    assert not result.lethal[: len(floor)][x > 0.31].any()


# mean, maximum and number above the threshold of the sheet; None where it has none
PUBLISHED = {
    (TRAY, "Roughness"): (0.0195, 0.7088, 34),
    (TRAY, "Ridge"): (0.4057, 0.8637, None),
    (TRAY, "Steepness"): (0.4417, 1.5708, 401),
    (BOTANICAL, "HeightDiff"): (0.2261, 0.4570, None),
    (BOTANICAL, "Roughness"): (0.6768, None, None),
}


@pytest.mark.parametrize("name, kind", PUBLISHED, ids=["-".join(key) for key in PUBLISHED])
def test_published_numbers(name, kind):
    """Of the released formulas (radius 0.3) on meshes as they are, which these oracles know."""
    _, oracle = scaled(name)
    released = {
        "HeightDiff": lambda: layer_oracles.height_difference(oracle, 0.3, False, -np.inf),
        "Roughness": lambda: layer_oracles.roughness(oracle, 0.3, include_vertex=False),
        "Ridge": lambda: layer_oracles.ridge(oracle, 0.3, lonely=0.4),
        "Steepness": lambda: layer_oracles.steepness(oracle),
    }[kind]()
    finite = released[np.isfinite(released)]
    mean, largest, above = PUBLISHED[name, kind]
    assert finite.mean() == pytest.approx(mean, abs=6e-5)
    assert largest is None or finite.max() == pytest.approx(largest, abs=6e-5)
    assert above is None or (released > layer_threshold(kind)).sum() == above
    if kind == "Roughness":  # the layer itself as it comes has them, too
        layer = evaluated(kind, scaled(name)[0])
        assert layer.costs.mean(dtype=np.float64) == pytest.approx(mean, abs=6e-5)
        assert above is None or layer.lethal.sum() == above


@pytest.mark.parametrize("name, lonely", [(TRAY, 1169), (BOTANICAL, 84)])
def test_vertices_without_neighbors(name, lonely):
    """As released they had height differences of -inf, no roughness, and a ridge of the threshold +
    0.1; now 0 for all but a height difference without the vertex itself, which is not known."""
    mesh, oracle = scaled(name)
    alone = np.ones(oracle.count, bool)
    alone[oracle.neighborhoods(0.3)[0]] = False
    assert alone.sum() == lonely
    released = layer_oracles.height_difference(oracle, 0.3, False, -np.inf)
    assert np.array_equal(np.isneginf(released), alone)
    assert not evaluated("HeightDiff", mesh, large_faces=False).costs[alone].any()
    without = evaluated("HeightDiff", mesh, include_vertex=False, large_faces=False)
    assert np.array_equal(np.isnan(without.costs), alone) and not without.lethal[alone].any()
    for kind in ("Ridge", "Roughness"):
        assert not evaluated(kind, mesh).costs[alone].any()
    roughness = evaluated("Roughness", mesh, include_vertex=True).costs[alone]
    np.testing.assert_allclose(roughness, layer_oracles.mean_angle(oracle)[alone], atol=ANGLE)


def test_published_numbers_of_the_border_and_of_normals():
    assert evaluated("Border", data_mesh(TRAY)).lethal.sum() == 96
    mesh = data_mesh(TRAY)
    steepness = evaluated("Steepness", mesh)
    assert steepness.lethal.sum() == 401
    assert steepness.costs.mean(dtype=np.float64) == pytest.approx(0.4417, abs=6e-5)
    ridge = evaluated("Ridge", mesh).costs.astype(np.float64)
    assert ridge.max() == pytest.approx(0.8637, abs=6e-5)
    assert evaluated("Steepness", data_mesh(BOTANICAL)).costs.max() > 3.14


@pytest.mark.parametrize("kind", ["HeightDiff", "Roughness", "Steepness"])
def test_a_level_plane_costs_nothing(kind):
    for name in ("grid", "jittered_plane", "hole", "two_components"):
        mesh, _ = scaled(name)
        assert not evaluated(kind, mesh).costs.any()


def test_the_ridge_of_a_plane_is_the_mean_distance():
    mesh, oracle = scaled("grid")
    center, reached = oracle.neighborhoods(0.45)
    away = np.linalg.norm(oracle.points[center] - oracle.points[reached], axis=1)
    total, number = layer_oracles.per_vertex(oracle.count, center, away)
    costs = evaluated("Ridge", mesh, radius=0.45).costs
    np.testing.assert_allclose(costs, total / number, rtol=1e-6)
