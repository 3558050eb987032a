"""Places where a robot may stand."""

import numpy as np
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs.world.solids import box, floor, joined
from mesh_msgs.zoo import two_storeys

from mesh_localization.relocalization.pose_sampling import (
    SearchRegion,
    PoseLimits,
    places_around,
    sampled_places,
)


def geometry_of(*parts):
    return MeshGeometry(*joined(*parts))


def tilted(angle):
    """A floor of 10 x 10 m that rises along x."""
    vertices, faces = floor((0, 0), (10, 10), 1.0)
    vertices[:, 2] = np.tan(angle) * vertices[:, 0]
    return vertices, faces


def test_all_storeys_and_the_ramp_have_places():
    mesh = two_storeys(24)
    places = sampled_places(MeshGeometry(mesh.vertices, mesh.faces), 0.5)
    z = places.positions[:, 2]
    lower, upper = (np.isclose(z, level, atol=1e-6).sum() for level in (0.0, 3.0))
    assert lower > 500 and upper > 500
    assert len(z) - lower - upper > 30, "none on the ramp"


def test_frames_stand_on_the_ground():
    places = sampled_places(MeshGeometry(*tilted(0.3)), 1.0)
    assert len(places.positions) == 100  # 10 x 10 m seen from above
    normal = np.array([-np.sin(0.3), 0, np.cos(0.3)])
    inner = np.all(abs(places.positions[:, :2] - 5) < 4, axis=1)
    np.testing.assert_allclose(places.frames[inner][:, :, 2] @ normal, 1.0, atol=1e-9)
    turned = np.einsum("pji,pjk->pik", places.frames, places.frames)
    np.testing.assert_allclose(turned, np.broadcast_to(np.eye(3), turned.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(places.frames), 1.0)


def test_steep_low_and_upside_down_places_are_left_out():
    steep = tilted(0.8)
    assert not len(sampled_places(MeshGeometry(*steep), 1.0).positions)
    allowed = PoseLimits(max_slope=0.9)
    assert len(sampled_places(MeshGeometry(*steep), 1.0, limits=allowed).positions)
    vertices, faces = floor((0, 0), (10, 10), 1.0)
    # A slab of 1 m above half of the floor, and one on its own that looks down.
    slab = box((0, 0, 0.5), (5, 10, 0.6))
    places = sampled_places(geometry_of((vertices, faces), slab), 1.0)
    below = places.positions[places.positions[:, 2] < 0.1]
    assert (below[:, 0] > 5).all() and len(below) == 50
    assert (places.positions[:, 2] > 0.55).sum() == 50, "its top can be stood on"


def test_a_region_bounds_places():
    mesh = two_storeys(24)
    region = SearchRegion(np.array([6.0, 6.0, 3.0]), 2.0)
    places = sampled_places(MeshGeometry(mesh.vertices, mesh.faces), 0.25, region=region)
    assert 180 < len(places.positions) < 220  # 4 pi m2
    assert (np.linalg.norm(places.positions - region.center, axis=1) <= 2).all()
    assert (places.positions[:, 2] > 2.9).all(), "the other storey is 3 m below"
    away = SearchRegion(np.array([60.0, 6.0, 3.0]), 2.0)
    assert not len(sampled_places(MeshGeometry(mesh.vertices, mesh.faces), 0.25, region=away)[0])


def test_nine_places_around_each_as_far_as_there_is_ground():
    geometry = MeshGeometry(*tilted(0.3))
    places = sampled_places(geometry, 2.0)
    around = places_around(geometry, places, 0.5)
    assert len(around.positions) == 9 * len(places.positions)
    height = np.tan(0.3) * around.positions[:, 0]
    np.testing.assert_allclose(around.positions[:, 2], height, atol=1e-5)
    far = places_around(geometry, places, 2.5)
    assert len(far.positions) < len(around.positions), "some lie beside the mesh"
