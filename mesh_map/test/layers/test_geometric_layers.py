"""Roughness, ridge, steepness and border: formulas of the sheet, and its oracle numbers."""

import numpy as np
import pytest
import surroundings
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.layers.threshold_layer import BorderLayer, RidgeLayer, RoughnessLayer, SteepnessLayer
from mesh_map.map.mesh_map import MeshMap
from meshes import BOTANICAL, TRAY, TestMesh, data_mesh, small, terrain

PARAMETERS = {
    RoughnessLayer: {
        "threshold": (0.3, 0.01, 3.1415),
        "radius": (0.3, 0.02, 1.0),
        "include_vertex": (False, None, None),
    },
    RidgeLayer: {"threshold": (0.3, 0.01, 3.1415), "radius": (0.3, 0.01, 1.0)},
    SteepnessLayer: {"threshold": (0.3, 0.01, 3.1415)},
    BorderLayer: {"threshold": (0.5, 0.05, 1.0), "border_cost": (1.0, 0.02, 10.0)},
}


def evaluated(layer_type, mesh, params=None, **options):
    mesh_map = MeshMap.of(MeshGeometry(mesh.vertices, mesh.faces, **options))
    layer = layer_type("layer", params or {})
    layer.announce(mesh_map.geometry)
    return layer.evaluate(mesh_map, {})


@pytest.mark.parametrize("layer_type", PARAMETERS)
def test_declared_parameters(layer_type):
    declared = {p.name: (p.default, p.minimum, p.maximum) for p in layer_type.PARAMETERS}
    assert declared == PARAMETERS[layer_type]


@pytest.mark.parametrize("layer_type", PARAMETERS)
def test_costs_are_usable_on_every_mesh(layer_type):
    for mesh in (terrain(10), data_mesh(BOTANICAL)):
        result = evaluated(layer_type, mesh)
        assert np.isfinite(result.costs).all() and (result.costs >= 0).all()


@pytest.mark.parametrize("layer_type", PARAMETERS)
def test_lethal_is_above_the_threshold(layer_type):
    mesh = terrain(20)
    threshold = float(np.median(evaluated(layer_type, mesh).costs)) or 0.9
    result = evaluated(layer_type, mesh, {"threshold": threshold})
    assert np.array_equal(result.lethal, result.costs > np.float32(threshold))
    assert 0 < result.lethal.sum() < len(result.lethal)


@pytest.mark.parametrize("layer_type", PARAMETERS)
def test_a_new_threshold_reuses_costs(layer_type):
    result = evaluated(layer_type, terrain(20))
    reused = layer_type("layer", {"threshold": 0.2}).reuse(result.costs, None, {})
    assert reused.costs is result.costs
    assert np.array_equal(reused.lethal, result.costs > np.float32(0.2))


@small
def test_steepness(mesh):
    normals = MeshGeometry(mesh.vertices, mesh.faces).vertex_normals.astype(np.float64)
    expected = np.arctan2(np.hypot(normals[:, 0], normals[:, 1]), normals[:, 2])
    np.testing.assert_allclose(evaluated(SteepnessLayer, mesh).costs, expected, atol=1e-6)


def test_steepness_of_a_slope():
    mesh = terrain(20)
    x = mesh.vertices[:, 0]
    for slope in (0.0, 1e-5, 0.1, 1.0, 30.0):
        plane = np.stack([x, mesh.vertices[:, 1], slope * x], 1)
        ours = evaluated(SteepnessLayer, TestMesh("plane", plane, mesh.faces)).costs
        np.testing.assert_allclose(ours, np.arctan(slope), rtol=1e-4, atol=1e-7)


def test_steepness_where_faces_point_down():
    mesh = terrain(20)
    down = TestMesh("down", mesh.vertices, mesh.faces[:, ::-1].copy())
    expected = evaluated(SteepnessLayer, mesh).costs
    assert expected.max() < np.pi / 2 < evaluated(SteepnessLayer, down).costs.min()
    assert np.array_equal(evaluated(SteepnessLayer, down, orient=True).costs, expected)
    below = evaluated(SteepnessLayer, down, up_direction=(0, 0, -2)).costs
    np.testing.assert_allclose(below, expected, atol=1e-6)


@small
def test_border(mesh):
    topology = MeshMap(mesh.vertices, mesh.faces).topology
    on_border = np.zeros(len(mesh.vertices), bool)
    for edge, count in zip(topology.edges, topology.edge_face_counts):
        on_border[edge] |= count == 1
    result = evaluated(BorderLayer, mesh, {"border_cost": 2.5})
    assert np.array_equal(result.costs, np.where(on_border, np.float32(2.5), np.float32(0)))
    assert np.array_equal(result.lethal, on_border)
    assert not evaluated(BorderLayer, mesh, {"border_cost": 0.5}).lethal.any()


def released(mesh):
    """Roughness and ridge as released, and what they are made of."""
    geometry = MeshGeometry(mesh.vertices, mesh.faces)
    normals = geometry.vertex_normals
    around = surroundings.neighborhoods(mesh, 0.3)
    topology = geometry.topology
    angles = surroundings.mean_edge_angles(mesh, normals)
    as_released = angles.copy()
    as_released[topology.edges[topology.non_manifold_edges]] = np.pi  # none in these meshes
    rough = surroundings.roughness(around, as_released, own=False)
    return rough, surroundings.ridge(mesh, normals, around, alone=0.3 + 0.1), around, angles


def test_tray():
    mesh = data_mesh(TRAY)
    rough, ridge, around, angles = released(mesh)
    assert rough.mean() == pytest.approx(0.0195, abs=6e-5)
    assert rough.max() == pytest.approx(0.7088, abs=6e-5) and (rough > 0.3).sum() == 34
    assert ridge.mean() == pytest.approx(0.4057, abs=6e-5)
    assert ridge.max() == pytest.approx(0.8637, abs=6e-5)
    steepness = evaluated(SteepnessLayer, mesh)
    assert steepness.costs.mean() == pytest.approx(0.4417, abs=6e-5)
    assert steepness.costs.max() == pytest.approx(1.5708, abs=6e-5)
    assert steepness.lethal.sum() == 401
    assert evaluated(BorderLayer, mesh).lethal.sum() == 96

    ours = evaluated(RidgeLayer, mesh).costs
    lonely = np.array([not len(others) for others in around])
    np.testing.assert_allclose(ours[~lonely], ridge[~lonely], atol=2e-6)
    assert lonely.sum() == 1169 and not ours[lonely].any()
    ours = evaluated(RoughnessLayer, mesh)
    np.testing.assert_allclose(ours.costs, rough, atol=2e-6)
    assert np.array_equal(ours.lethal, rough > 0.3) and not ours.costs[lonely].any()
    with_vertex = evaluated(RoughnessLayer, mesh, {"include_vertex": True}).costs
    np.testing.assert_allclose(with_vertex, surroundings.roughness(around, angles), atol=2e-6)
    np.testing.assert_allclose(with_vertex[lonely], angles[lonely], atol=2e-6)


def test_botanical_garden():
    mesh = data_mesh(BOTANICAL)
    rough, ridge, around, angles = released(mesh)
    assert rough.mean() == pytest.approx(0.6768, abs=6e-5)
    assert evaluated(SteepnessLayer, mesh).costs.max() == pytest.approx(3.14, abs=5e-3)
    np.testing.assert_allclose(evaluated(RoughnessLayer, mesh).costs, rough, atol=3e-6)
    with_vertex = evaluated(RoughnessLayer, mesh, {"include_vertex": True}).costs
    np.testing.assert_allclose(with_vertex, surroundings.roughness(around, angles), atol=3e-6)
    lonely = np.array([not len(others) for others in around])
    costs = evaluated(RidgeLayer, mesh).costs
    assert lonely.sum() == 84 and not costs[lonely].any()
    np.testing.assert_allclose(costs[~lonely], ridge[~lonely], atol=3e-6)
