"""Scans laid onto a surface that they were measured on."""

import numpy as np
import pytest
from mesh_msgs.outdoor_world import outdoor_world

from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.registration.rigid import inverse, motion, moved, numbers_of


@pytest.fixture(scope="module")
def world():
    return outdoor_world(20_000)


@pytest.fixture(scope="module")
def target(world):
    return PlaneTarget.of(world.vertices, world.faces)


def scan_at(target, world, seed, noise=0.0):
    """(pose, points): rays from 1 m above some ground."""
    random = np.random.default_rng(seed)
    low, high = world.vertices.min(0)[:2] + 6, world.vertices.max(0)[:2] - 6
    down = target.index.cast(origin=[*random.uniform(low, high), 100.0], direction=[0, 0, -1])
    turn = np.r_[0.1 * random.standard_normal(2), random.uniform(-3, 3)]
    pose = motion(np.r_[np.array(down.position) + [0, 0, 1.0], turn])
    rays = random.standard_normal((4000, 3)) * [1, 1, 0.4]
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    hits = target.index.cast_batch(
        origins=pose[:3, 3], directions=rays @ pose[:3, :3].T, max_distance=15.0
    )
    seen = np.isfinite(hits.distances)
    ranges = hits.distances[seen] + noise * random.standard_normal(seen.sum())
    return pose, ranges[:, None] * rays[seen]


def off(pose, truth):
    numbers = numbers_of(inverse(truth) @ pose)
    return np.linalg.norm(numbers[:3]), np.linalg.norm(numbers[3:])


@pytest.mark.parametrize("noise, most", [(0.0, 0.003), (0.015, 0.01)])
def test_a_scan_goes_where_it_was_measured(target, world, noise, most):
    random = np.random.default_rng(5)
    errors = []
    for seed in range(20):
        truth, points = scan_at(target, world, seed, noise)
        wrong = np.r_[0.15 * random.standard_normal(3), 0.02 * random.standard_normal(3)]
        found = target.register(points, truth @ motion(wrong), max_distance=1.0)
        assert found.share > 0.8 and found.residual < noise + 0.01
        errors.append(off(found.pose, truth)[0])
    assert np.median(errors) < most and max(errors) < 5 * most


def test_where_the_surface_does_not_tell_nothing_is_moved():
    side = np.linspace(-10, 10, 41)
    x, y = np.meshgrid(side, side)
    vertices = np.float32(np.c_[x.ravel(), y.ravel(), np.zeros(x.size)])
    corner = np.add.outer(np.arange(40) * 41, np.arange(40)).ravel()
    faces = np.concatenate(
        [np.c_[corner, corner + 1, corner + 42], np.c_[corner, corner + 42, corner + 41]]
    )
    plane = PlaneTarget.of(vertices, faces)
    random = np.random.default_rng(0)
    points = np.c_[random.uniform(-3, 3, (2000, 2)), np.full(2000, -1.0)]
    guess = motion([0.3, -0.2, 1.2, 0.02, -0.01, 0.4])
    found = plane.register(points, guess)
    numbers = numbers_of(found.pose)
    assert abs(numbers[2] - 1.0) < 1e-6 and np.abs(moved(found.pose, points)[:, 2]).max() < 1e-6
    assert np.linalg.norm(found.pose[:2, 3] - guess[:2, 3]) < 0.03  # but for the tilt
    heading = np.arctan2(found.pose[1, 0], found.pose[0, 0])
    assert abs(heading - np.arctan2(guess[1, 0], guess[0, 0])) < 0.01
    values = np.linalg.eigvalsh(found.information)
    assert (values[:3] < 1e-6 * values[-1]).all() and (values[3:] > 1e-3 * values[-1]).all()


def test_a_prior_holds_where_the_points_say_little(target, world):
    truth, points = scan_at(target, world, 3)
    wrong = truth @ motion([0.1, 0.0, 0.0, 0.0, 0.0, 0.0])
    free = target.register(points, wrong)
    held = target.register(points, wrong, prior=1e9 * np.eye(6))
    assert off(free.pose, truth)[0] < 0.01
    assert off(held.pose, wrong)[0] < 1e-3


def test_points_that_see_no_surface_from_its_front_are_no_match(target, world):
    truth, points = scan_at(target, world, 1)
    from_below = np.array([0.0, 0.0, -50.0])
    few = target.register(points, truth, origins=from_below)
    assert few is None or few.count < 0.3 * len(points)
    far = motion([0, 0, 500.0, 0, 0, 0]) @ truth
    assert target.register(points, far) is None


@pytest.mark.parametrize("noise, most", [(0.0, 0.001), (0.015, 0.01)])
def test_rays_find_their_place_from_farther_away(target, world, noise, most):
    random = np.random.default_rng(6)
    errors = []
    for seed in range(20):
        truth, points = scan_at(target, world, seed, noise)
        shift, turn = random.standard_normal((2, 3))
        wrong = np.r_[0.4 * shift / np.linalg.norm(shift), 0.08 * turn / np.linalg.norm(turn)]
        found = target.register(points, truth @ motion(wrong), matching="rays", max_distance=1.5)
        assert found.told >= 5
        errors.append(off(found.pose, truth)[0])
    assert np.median(errors) < most and np.percentile(errors, 90) < 5 * most


def test_rays_do_not_ask_which_side_of_a_face_they_meet(world):
    """Maps of scans and of CAD have faces that look away from the sensor."""
    flipped = PlaneTarget.of(world.vertices, world.faces[:, ::-1])
    truth, points = scan_at(flipped, world, 2)
    guess = truth @ motion([0.1, -0.1, 0.1, 0.01, 0.0, 0.02])
    assert off(flipped.register(points, guess, matching="rays").pose, truth)[0] < 1e-3
    from_behind = flipped.register(points, guess)
    assert from_behind is None or from_behind.count < 0.5 * len(points)


def rough_plane(roughness, seed=0):
    """16 x 16 m of faces of 20 cm whose corners scatter in height (m)."""
    side = np.linspace(-8, 8, 81)
    x, y = np.meshgrid(side, side)
    z = roughness * np.random.default_rng(seed).standard_normal(x.size)
    corner = np.add.outer(np.arange(80) * 81, np.arange(80)).ravel()
    faces = np.concatenate(
        [np.c_[corner, corner + 1, corner + 82], np.c_[corner, corner + 82, corner + 81]]
    )
    return PlaneTarget.of(np.float32(np.c_[x.ravel(), y.ravel(), z]), faces)


@pytest.mark.parametrize("roughness, told", [(0.0, 3), (0.004, 3), (0.05, 6)])
def test_normals_that_scatter_a_little_tell_nothing(roughness, told):
    """A floor of a reconstruction, whose normals are off by 2 degrees, looks as if one could see
    where one is along it; ground whose faces differ by 20 degrees does tell it."""
    random = np.random.default_rng(1)
    away, around = random.uniform(0.5, 6, 3000), random.uniform(0, 6.3, 3000)
    points = np.c_[away * np.cos(around), away * np.sin(around), np.full(3000, -1.0)]
    guess = motion([0, 0, 1.0, 0, 0, 0])
    surface = rough_plane(roughness)
    rays = surface.cast(points, np.zeros(3), guess)
    points = rays.hits.distances[:, None] * rays.directions  # as measured there
    found = surface.register(points, guess @ motion([0.02, 0.02, 0, 0, 0, 0.0]), matching="rays")
    assert found.told == told
    values = np.linalg.eigvalsh(found.information)
    assert np.count_nonzero(values > 1e-6 * values[-1]) == told
    moved_by = np.linalg.norm(found.pose[:2, 3] - [0.02, 0.02])
    assert (moved_by < 1e-3) == (told == 3)
