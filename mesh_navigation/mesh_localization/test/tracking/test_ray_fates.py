"""The fate of rays in a room whose walls are known."""

import numpy as np
import pytest
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.registration.rigid import motion
from mesh_msgs.world.solids import box

from mesh_localization.tracking.ray_fates import RayFate, ray_fates

TOLERANCE = 0.1
POSE = motion([1.0, -0.5, 0.2, 0.1, 0.2, 0.8])


@pytest.fixture(scope="module")
def room():
    """10 x 8 x 4 m around the origin, without its ceiling."""
    vertices, faces = box([-5, -4, -2], [5, 4, 2])
    vertices, faces = np.float32(vertices), np.asarray(faces)
    open_above = ~(vertices[faces][:, :, 2] == 2).all(axis=1)
    return PlaneTarget.of(vertices, faces[open_above])


def rays(room, count=500):
    """(directions, true ranges) in the robot's frame; inf above the walls."""
    random = np.random.default_rng(4)
    directions = random.standard_normal((count, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    hits = room.index.cast_batch(origins=POSE[:3, 3], directions=directions @ POSE[:3, :3].T)
    return directions, hits.distances


def fates(room, points):
    return ray_fates(room, points, np.zeros(3), POSE, TOLERANCE)


def test_what_the_map_shows_is_explained(room):
    directions, ranges = rays(room)
    met = np.isfinite(ranges)
    found = fates(room, directions[met] * ranges[met, None])
    assert (found.fates == RayFate.EXPLAINED).all() and found.share == 1.0
    assert found.residual < 1e-5 and np.abs(found.distances).max() < 1e-5


def test_obstacles_are_before_and_do_not_lower_the_share(room):
    directions, ranges = rays(room)
    met = np.flatnonzero(np.isfinite(ranges))
    shortened = ranges[met].copy()
    shortened[::3] *= 0.3  # m; all walls are farther than 1.4 m away
    found = fates(room, directions[met] * shortened[:, None])
    assert (found.fates[::3] == RayFate.BEFORE).all()
    assert found.count(RayFate.BEFORE) == len(shortened[::3]) and found.share == 1.0


def test_what_goes_through_walls_lowers_the_share(room):
    directions, ranges = rays(room)
    met = np.flatnonzero(np.isfinite(ranges))
    longer = ranges[met].copy()
    longer[::4] += 2.0
    found = fates(room, directions[met] * longer[:, None])
    assert (found.fates[::4] == RayFate.THROUGH).all()
    assert found.share == pytest.approx(1 - len(longer[::4]) / len(longer))


def test_what_meets_nothing_is_off_the_map(room):
    directions, ranges = rays(room)
    above = np.isinf(ranges)
    found = fates(room, directions * np.where(above, 3.0, ranges)[:, None])
    assert (found.fates[above] == RayFate.OFF_MAP).all() and found.share == 1.0
    assert np.isnan(found.distances[above]).all()


def test_no_ray_at_all(room):
    found = fates(room, np.zeros((0, 3)))
    assert found.share == 0.0 and np.isnan(found.residual)
