"""The layer of collisions, against every face and every other one in plain NumPy."""

import numpy as np
import pytest
from collision_oracle import CollisionOracle
from layer_calls import evaluated, made, scaled
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.layers.collision import collisions
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.world.solids import box, floor, joined
from meshes import SMALL, TestMesh, soup, terrain

# Those left out are far from the origin, or long soups, which take the oracle half a minute each.
LEFT_OUT = ("far_sphere", "soup_5", "soup_6")
NAMES = [mesh.name for mesh in SMALL if mesh.name not in LEFT_OUT]
every = pytest.mark.parametrize("name", NAMES)
SIZES = ((0.1, 0.4), (0.03, 2.0))  # step_height, robot_height


def found(mesh, radius, sizes, **options):
    geometry = MeshGeometry(mesh.vertices, mesh.faces, **options)
    step, height = sizes
    return collisions(geometry, robot_radius=radius, step_height=step, robot_height=height)


def within(lethal, least, most):
    """Between the bounds, which are not far from each other."""
    np.testing.assert_array_equal(lethal & least, least)
    np.testing.assert_array_equal(lethal & most, lethal)
    return (least == most).sum()


@every
@pytest.mark.parametrize("sizes", SIZES)
def test_points_follow_the_definition(name, sizes):
    mesh, _ = scaled(name)
    lethal = found(mesh, 0.0, sizes)
    decided = within(lethal, *CollisionOracle(mesh, *sizes).point_bounds())
    assert decided >= 0.9 * len(lethal) or len(lethal) < 30


@every
def test_bodies_follow_the_definition(name):
    mesh, _ = scaled(name)
    for sizes in SIZES:
        points, bodies = found(mesh, 0.0, sizes), found(mesh, 0.25, sizes)
        within(bodies, *CollisionOracle(mesh, *sizes).body_bounds(0.25, points))


@pytest.mark.parametrize("seed", range(20))
def test_small_soups_follow_the_definition(seed):
    """Random triangles one over the other, in which each rule is met."""
    mesh = soup(seed, 40, 40)
    flat = (mesh.vertices * np.float32([0.6, 0.6, 0.3])).astype(np.float32)
    mesh, sizes = TestMesh("soup", flat, mesh.faces), (0.05, 0.3)
    lethal = found(mesh, 0.0, sizes)
    oracle = CollisionOracle(mesh, *sizes)
    assert within(lethal, *oracle.point_bounds()) > 0.9 * len(lethal)
    assert 0 < lethal.sum() < len(lethal)
    for radius in (0.2, 1.0):
        within(found(mesh, radius, sizes), *oracle.body_bounds(radius, lethal))


def test_what_the_zoo_decides():
    """Neither everything nor nothing is lethal there, with and without a radius."""
    meshes = [scaled(name)[0] for name in NAMES]
    points, bodies = (
        np.concatenate([found(mesh, radius, SIZES[1]) for mesh in meshes]) for radius in (0.0, 0.25)
    )
    assert 100 < points.sum() < bodies.sum() < 0.9 * len(points)
    assert not (points & ~bodies).any()


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [1, -1])
def test_up_may_be_any_direction(axis, sign):
    """On a mesh that is turned with it, exactly the same along axes."""
    mesh, _ = scaled("torus")
    turn = np.roll(np.eye(3, dtype=np.float32), axis + 1, axis=0)
    turn = turn * np.float32(sign)
    turn[axis - 1] *= np.linalg.det(turn)  # no mirror
    vertices = mesh.vertices @ turn.T
    for radius in (0.0, 0.25):
        expected = found(mesh, radius, SIZES[0])
        assert 0 < expected.sum() < len(expected)
        turned = TestMesh("turned", vertices, mesh.faces)
        lethal = found(turned, radius, SIZES[0], up_direction=turn @ [0, 0, 1])
        np.testing.assert_array_equal(lethal, expected)


def test_up_may_lean():
    parts = joined(floor((0, 0), (4, 4), 0.1), box((1.02, 1.03, 0), (2.04, 2.55, 1)))
    expected = found(TestMesh("flat", np.float32(parts[0]), parts[1]), 0.3, (0.1, 0.5))
    up = np.array([0.3, -0.2, 0.9]) / np.linalg.norm([0.3, -0.2, 0.9])
    across = np.cross(up, [1, 0, 0]) / np.linalg.norm(np.cross(up, [1, 0, 0]))
    turn = np.stack([across, np.cross(up, across), up])
    leaning = TestMesh("leaning", np.float32(parts[0] @ turn), parts[1])
    lethal = found(leaning, 0.3, (0.1, 0.5), up_direction=up)
    np.testing.assert_array_equal(lethal, expected)


def test_nothing_depends_on_the_turn_of_faces():
    mesh = terrain()
    both = joined((mesh.vertices, mesh.faces), box((1.1, 1.2, -1), (2.3, 1.9, 1)))
    mesh = TestMesh("box on terrain", np.float32(both[0]), np.uint32(both[1]))
    random = np.random.default_rng(3)
    faces = mesh.faces.copy()
    some = random.random(len(faces)) < 0.5
    faces[some] = faces[some][:, ::-1]
    for radius in (0.0, 0.3):
        expected = found(mesh, radius, SIZES[0])
        lethal = found(TestMesh("turned", mesh.vertices, faces), radius, SIZES[0])
        np.testing.assert_array_equal(lethal, expected)


def test_the_layer():
    """Costs, parameters, and costs that are used again."""
    parts = joined(floor((0, 0), (4, 4), 0.1), box((1, 1, 0), (2, 2, 1)))
    mesh = TestMesh("room", np.float32(parts[0]), np.uint32(parts[1]))
    sizes = {"step_height": 0.1, "robot_height": 0.4, "robot_radius": 0.3}
    result = evaluated("Collision", mesh, **sizes)
    np.testing.assert_array_equal(result.lethal, found(mesh, 0.3, (0.1, 0.4)))
    np.testing.assert_array_equal(result.costs, result.lethal.astype(np.float32))
    assert result.costs.dtype == np.float32 and 0 < result.lethal.sum() < len(result.lethal)
    mesh_map, layer = MeshMap(mesh.vertices, mesh.faces), made("Collision", **sizes)
    reused = layer.reuse(result.costs, mesh_map, {})
    np.testing.assert_array_equal(reused.lethal, result.lethal)
    plain = made("Collision")
    assert [plain.params[name] for name in sorted(sizes)] == [0.5, 0.0, 0.185]
    identity = layer.fingerprint(mesh_map, {})
    for name in sizes:
        other = made("Collision", **{**sizes, name: 0.35}).fingerprint(mesh_map, {})
        assert other != identity and {**other, name: identity[name]} == identity


def test_steps_as_high_as_the_robot_are_refused():
    mesh = terrain(6)
    with pytest.raises(MeshMapError, match=r"step_height \(0.5 m\) has to be below robot_height"):
        evaluated("Collision", mesh, step_height=0.5, robot_height=0.5)


def test_a_change_of_parameters_comes_into_force():
    parts = joined(floor((0, 0), (4, 4), 0.1), box((1, 1, 0.6), (2, 2, 1)))
    mesh_map = MeshMap(*parts)
    layer = {"name": "collision", "type": "mesh_layers/CollisionLayer", "robot_height": 0.5}
    mesh_map.compute_layers([layer])
    floors = slice(0, 41 * 41)
    assert not np.isposinf(mesh_map.costs[floors]).any()
    for height in (0.7, 0.5, 0.7):
        mesh_map.set_layer_parameters("collision", {"robot_height": height})
        expected = collisions(
            mesh_map.geometry, robot_radius=0.0, step_height=0.185, robot_height=height
        )
        np.testing.assert_array_equal(np.isposinf(mesh_map.costs), expected)
        assert expected[floors].sum() == (121 if height > 0.6 else 0)
    assert "step_height" not in (mesh_map.fault or "")
    with pytest.raises(MeshMapError, match="has to be below robot_height"):
        mesh_map.set_layer_parameters("collision", {"step_height": 0.8})
    np.testing.assert_array_equal(np.isposinf(mesh_map.costs), expected)
