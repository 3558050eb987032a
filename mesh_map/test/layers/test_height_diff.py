"""The height difference layer against a search in plain Python, and the sheet's oracle numbers."""

import numpy as np
import pytest
from mesh_map.layers.threshold_layer import HeightDiffLayer
from mesh_map.map.mesh_map import MeshMap
from meshes import BOTANICAL, TRAY, TestMesh, data_mesh, renumbered, small, terrain
from surroundings import neighborhoods


def evaluated(mesh, **params):
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    return HeightDiffLayer("height_diff", params).evaluate(mesh_map, {})


def height_diff(mesh, **params):
    """Of vertices alone, as released."""
    return evaluated(mesh, large_faces=False, **params)


def expected(mesh, radius):
    z = mesh.vertices[:, 2]
    around = [np.append(others, v) for v, others in enumerate(neighborhoods(mesh, radius))]
    return np.array([np.ptp(z[rows]) for rows in around], np.float32)


@small
@pytest.mark.parametrize("radius", [0.05, 0.3, 1.0])
def test_equals_plain_python(mesh, radius):
    assert np.array_equal(height_diff(mesh, radius=radius).costs, expected(mesh, radius))


@pytest.mark.parametrize("radius", [0.1, 0.3])
def test_equals_plain_python_on_terrain(radius):
    mesh = terrain()
    costs = height_diff(mesh, radius=radius).costs
    assert np.array_equal(costs, expected(mesh, radius)) and costs.max() > 0.05


def test_tray():
    """Mean edge 0.51 m: as released, only 88 vertices have neighbors; the others have 0 here."""
    mesh = data_mesh(TRAY)
    costs = height_diff(mesh).costs
    assert np.array_equal(costs, expected(mesh, 0.3))
    lonely = np.array([not len(others) for others in neighborhoods(mesh, 0.3)])
    assert (~lonely).sum() == 88 and not costs[lonely].any() and np.isfinite(costs).all()


def test_botanical_garden():
    """Without the vertex itself, as released, our neighborhoods give the released numbers."""
    mesh = data_mesh(BOTANICAL)
    z = mesh.vertices[:, 2]
    rows = neighborhoods(mesh, 0.3)
    costs = height_diff(mesh).costs
    assert np.array_equal(costs, expected(mesh, 0.3))
    released = np.array([np.ptp(z[n]) if len(n) else -np.inf for n in rows], np.float32)
    finite = np.isfinite(released)
    assert (~finite).sum() == 84
    assert released[finite].mean(dtype=np.float64) == pytest.approx(0.2261, abs=5e-5)
    assert released[finite].max() == pytest.approx(0.4570, abs=5e-5)
    assert (costs[finite] >= released[finite]).all() and not costs[~finite].any()
    without = height_diff(mesh, include_vertex=False).costs
    assert np.array_equal(without[finite], released[finite]) and np.isnan(without[~finite]).all()


def test_a_lone_vertex_without_itself_is_unknown_and_never_free():
    mesh = data_mesh(TRAY)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    layer = {"name": "h", "type": "mesh_layers/HeightDiffLayer"}
    released = {"include_vertex": False, "large_faces": False}
    mesh_map.compute_layers([dict(layer, params=released)])
    lonely = np.array([not len(others) for others in neighborhoods(mesh, 0.3)])
    assert lonely.any() and np.array_equal(np.isnan(mesh_map.costs), lonely)


@pytest.mark.parametrize(
    "radius, threshold, warns", [(0.3, 0.25, 0), (0.25, 0.25, 1), (0.2, 0.25, 1)]
)
def test_a_radius_that_upright_steps_may_escape_is_warned_of(radius, threshold, warns):
    """From its rim, a step rises by the radius at most, and that has to be above the threshold."""
    params = {"radius": radius, "threshold": threshold}
    layer = HeightDiffLayer("steps", params)
    assert len(layer.warnings) == len(layer.checked_changes({})[1]) == warns
    assert not warns or "is not above threshold, 0.25 m: an upright step" in layer.warnings[0]
    assert not HeightDiffLayer("steps", dict(params, enabled=False)).warnings
    assert layer.sees_steps() == (not warns)
    assert not HeightDiffLayer("steps", dict(params, large_faces=False)).sees_steps()
    grid = terrain(20)
    row, y = (0.2 * part.ravel() for part in np.mgrid[:20, :20])
    row[row > 1.9] -= 0.2 - 1e-4  # as good as upright, as in CAD
    points = np.stack([row, y, np.where(np.arange(400) >= 200, 0.9, 0.0)], 1).astype(np.float32)
    lethal = evaluated(TestMesh("ledge", points, grid.faces), **params).lethal
    assert lethal.any() == (not warns)


def test_neighbors_are_reached_over_edges():
    """Two sheets 0.1 m apart that no edge connects do not see each other."""
    mesh = terrain(10)
    above = mesh.vertices + np.float32((0, 0, 0.1))
    two = TestMesh(
        "two",
        np.concatenate([mesh.vertices, above]),
        np.concatenate([mesh.faces, mesh.faces + np.uint32(100)]),
    )
    alone, both = height_diff(mesh).costs, height_diff(two).costs
    assert np.array_equal(both[:100], alone)


def test_the_radius_is_exclusive():
    mesh = TestMesh("steps", np.array([[0, 0, 0], [0.5, 0, 0.0], [0, 0, 0.5]]), [[0, 1, 2]])
    assert height_diff(mesh, radius=0.5).costs.tolist() == [0, 0, 0]
    wider = height_diff(mesh, radius=float(np.nextafter(0.5, 1))).costs.tolist()
    assert wider == [0.5, 0, 0.5]


def test_large_faces_count_where_nothing_is_said():
    """As far as they rise within the radius: never less than between vertices alone."""
    mesh = data_mesh(TRAY)
    geometry = MeshMap(mesh.vertices, mesh.faces).geometry
    costs, vertices = evaluated(mesh).costs, height_diff(mesh).costs
    assert np.array_equal(costs, geometry.radius_pass(0.3).surface_height_difference())
    assert (costs >= vertices).all() and (costs > vertices).mean() > 0.3
    without = evaluated(mesh, include_vertex=False).costs
    assert np.array_equal(without, geometry.radius_pass(0.3).surface_height_difference_around())
    fine = terrain()
    assert np.array_equal(evaluated(fine).costs, height_diff(fine).costs)


@pytest.mark.parametrize("high", [0.4, 1.0, 30.0])
def test_no_step_of_large_faces_is_free(high):
    """Of one row of faces, whose ends are farther from each other than the radius: nobody gets
    from one side to the other without a lethal vertex."""
    grid = terrain(20)
    row, y = (0.2 * part.ravel() for part in np.mgrid[:20, :20])
    points = np.stack([row, y, np.where(row > 1.9, high, 0.0)], 1).astype(np.float32)
    mesh = TestMesh("ledge", points, grid.faces)
    assert not height_diff(mesh).lethal.any()
    lethal = evaluated(mesh).lethal
    rim = np.isclose(row, 1.8) | np.isclose(row, 2.0)
    assert lethal[rim].all() and not lethal[np.abs(row - 1.9) > 0.5].any()


def test_the_order_of_vertices_does_not_matter():
    mesh = terrain()
    other, new = renumbered(mesh)
    assert np.array_equal(height_diff(mesh).costs, height_diff(other).costs[new])


def test_lethal_is_above_the_threshold():
    mesh = terrain()
    result = height_diff(mesh, threshold=0.1)
    assert np.array_equal(result.lethal, result.costs > np.float32(0.1))
    assert 0 < result.lethal.sum() < len(result.lethal)
