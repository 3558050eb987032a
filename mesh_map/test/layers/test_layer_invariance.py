"""What the costs of layers must not depend on."""

import numpy as np
import pytest
from layer_calls import evaluated, scaled
from layer_oracles import OracleMesh
from meshes import BOTANICAL, SMALL, TRAY, TestMesh, renumbered, terrain

MEASURING = ("HeightDiff", "Roughness", "Ridge", "Steepness", "Border", "Clearance")
NAMES = ["jittered_plane", "torus", "moebius_strip", "fan_of_three", "bow_tie", "flipped_face"]
NAMES += ["duplicate_face", "two_storeys", "soup_6", TRAY]
kinds = pytest.mark.parametrize("kind", MEASURING + ("Inflation",))
meshes = pytest.mark.parametrize("name", NAMES + ["terrain"])

# Angles are rounded before their cosine is turned around; ways of a front are not exact, and depend
# a little on which of two ways as long comes first.
TOLERANCE = {"Roughness": 1e-3, "Steepness": 1e-3, "Inflation": 0.02, "Clearance": 1e-3}


def mesh_of(name):
    if name == "terrain":
        mesh = terrain(25)
        return mesh, OracleMesh(mesh)
    return scaled(name)


def costs_of(kind, mesh, lethal, **geometry):
    """Of a layer; of lethal vertices where it needs them."""
    if kind != "Inflation":
        return evaluated(kind, mesh, geometry=geometry).costs
    return evaluated(kind, mesh, lethal, geometry, inscribed_radius=0.1, inflation_radius=1.0).costs


def some(count):
    return np.arange(0, count, 17)


def assert_alike(kind, found, expected, oracle):
    """Where no normal around is but rounding that is left of normals that cancel out."""
    sure = np.ones(oracle.count, bool)
    if kind != "HeightDiff" and kind != "Border" and kind != "Inflation":
        doubtful = oracle.normals[1] < 1e-3
        sure = ~doubtful
        for _ in range(4):  # so far does a neighborhood reach
            ends = doubtful[oracle.edges]
            doubtful[oracle.edges[ends.any(axis=1)].ravel()] = True
            sure &= ~doubtful
    differs = ~np.isclose(found, expected, rtol=1e-4, atol=TOLERANCE.get(kind, 1e-5))
    if kind == "Clearance":  # a ray may pass by an edge on either side
        assert differs[sure].mean() < 0.02
    else:
        assert not differs[sure].any(), np.abs(found - expected)[sure].max()


@kinds
@meshes
def test_the_order_of_vertices(kind, name):
    mesh, oracle = mesh_of(name)
    other, new = renumbered(mesh)
    found = costs_of(kind, other, new[some(oracle.count)])[new]
    assert_alike(kind, found, costs_of(kind, mesh, some(oracle.count)), oracle)


@kinds
@meshes
def test_the_order_of_faces_and_where_they_begin(kind, name):
    mesh, oracle = mesh_of(name)
    random = np.random.default_rng(0)
    faces = random.permutation(mesh.faces)
    turn = (np.arange(3) + random.integers(0, 3, (len(faces), 1))) % 3
    other = mesh._replace(faces=np.take_along_axis(faces, turn, axis=1))
    lethal = some(oracle.count)
    expected = costs_of(kind, mesh, lethal)
    assert_alike(kind, costs_of(kind, other, lethal), expected, oracle)


def turned(mesh, rotation, shift):
    """Moved without change of size, as well as 32 bits can."""
    points = mesh.vertices.astype(np.float64) @ np.transpose(rotation) + shift
    return mesh._replace(vertices=points.astype(np.float32))


@kinds
@meshes
def test_a_rigid_motion_that_keeps_up(kind, name):
    """By quarters, which keep coordinates, then by any angle, where no distance is the radius."""
    mesh, oracle = mesh_of(name)
    lethal = some(oracle.count)
    expected = costs_of(kind, mesh, lethal)
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    found = costs_of(kind, turned(mesh, quarter, (0, 0, 0)), lethal)
    assert_alike(kind, found, expected, oracle)
    if name in ("terrain", TRAY):
        s, c = np.sin(0.7), np.cos(0.7)
        rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        found = costs_of(kind, turned(mesh, rotation, (3, -5, 2)), lethal)
        differs = np.abs(found - expected) > 2e-3 if kind != "Clearance" else np.zeros(1)
        assert differs.mean() <= (0.01 if kind == "Inflation" else 0.001)


@pytest.mark.parametrize("kind", ["HeightDiff", "Roughness", "Ridge", "Steepness"])
@pytest.mark.parametrize("up", [(1, 0, 0), (0, -1, 0), (0, 0, -2), (1, 2, 2)])
def test_any_motion_if_up_goes_with_it(kind, up):
    mesh, oracle = mesh_of("terrain")
    expected = costs_of(kind, mesh, None)
    unit = np.asarray(up) / np.linalg.norm(up)
    across = np.cross(unit, (0.3, 0.5, -0.2))
    across /= np.linalg.norm(across)
    rotation = np.stack([across, np.cross(unit, across), unit], axis=1)
    found = costs_of(kind, turned(mesh, rotation, (0, 0, 0)), None, up_direction=up)
    differs = np.abs(found - expected) > 2e-3
    assert differs.mean() < 0.001


@kinds
@meshes
def test_vertices_without_faces(kind, name):
    """Wherever they are, they change nothing, cost nothing, and are no obstacle themselves."""
    mesh, oracle = mesh_of(name)
    lonely = mesh.vertices[:3] + np.float32(0.01)
    other = TestMesh(name, np.concatenate([mesh.vertices, lonely]), mesh.faces)
    lethal = some(oracle.count)
    found = costs_of(kind, other, lethal)
    assert np.array_equal(found[:-3], costs_of(kind, mesh, lethal))
    assert kind == "Clearance" or not found[-3:].any()


@kinds
@pytest.mark.parametrize("name", ["jittered_plane", TRAY, "terrain"])
def test_two_copies_far_apart_do_not_see_each_other(kind, name):
    mesh, oracle = mesh_of(name)
    far = mesh.vertices + np.float32((0, 0, 0)) + np.float32((64, 0, 0))
    faces = np.concatenate([mesh.faces, mesh.faces + np.uint32(oracle.count)])
    two = TestMesh(name, np.concatenate([mesh.vertices, far]), faces)
    lethal = some(oracle.count)
    both = costs_of(kind, two, np.concatenate([lethal, lethal + oracle.count]))
    assert np.array_equal(both[: oracle.count], costs_of(kind, mesh, lethal))


@pytest.mark.parametrize("kind", ["Steepness", "Roughness", "Ridge", "HeightDiff"])
def test_faces_that_point_down_are_right_when_oriented(kind):
    """The farmer's pit: the same costs as of the map whose faces point up."""
    mesh, oracle = mesh_of("terrain")
    down = mesh._replace(faces=mesh.faces[:, ::-1])
    expected = costs_of(kind, mesh, None)
    found = costs_of(kind, down, None, orient=True)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    mixed = mesh.faces.copy()
    mixed[::3] = mixed[::3, ::-1]
    found = costs_of(kind, mesh._replace(faces=mixed), None, orient=True)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    if kind == "Steepness":
        assert costs_of(kind, down, None).min() > np.pi / 2


@pytest.mark.parametrize("orient", [False, True])
@pytest.mark.parametrize("normals", ["mean", "angle"])
def test_every_layer_takes_every_mesh(orient, normals):
    for name in [mesh.name for mesh in SMALL] + [TRAY, BOTANICAL]:
        mesh, oracle = scaled(name)
        for kind in MEASURING + ("Inflation",):
            costs = costs_of(kind, mesh, some(oracle.count), orient=orient, normals=normals)
            assert costs.shape == (oracle.count,) and np.isfinite(costs).all(), (name, kind)
            assert (costs >= 0).all()
