"""Panoramas of scans, and how well they fit in each heading."""

import numpy as np
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.scans.lidar import LidarModel
from mesh_msgs.world.solids import box, flipped, floor, joined

from mesh_localization.relocalization.heading_scores import heading_scores
from mesh_localization.relocalization.pose_sampling import SampledPlaces
from mesh_localization.relocalization.range_panorama import map_ranges, panorama_of

HEIGHT = 0.7


def room():
    """8 x 5 m, with a floor."""
    return MeshGeometry(*joined(floor((0, 0), (8, 5), 1.0), flipped(box((0, 0, -0.1), (8, 5, 3)))))


def view_of(geometry, pose, model=LidarModel()):
    """The panorama of a lidar over the origin of a base that is 0.1 m above the ground."""
    directions = model.directions()
    origins = np.broadcast_to(pose[:3, 3] + [0, 0, HEIGHT], directions.shape)
    hits = geometry.spatial_index.cast_batch(
        origins=origins, directions=directions @ pose[:3, :3].T
    )
    points = hits.distances[:, None] * directions + [0, 0, HEIGHT - 0.1]
    return panorama_of(points, np.array([0, 0, HEIGHT - 0.1]), 0.1)


def turned(x, y, angle):
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    pose[:2, 3] = x, y
    return pose


def test_a_scan_is_what_the_map_shows_at_its_place():
    geometry = room()
    view = view_of(geometry, turned(3, 2, 0.0))
    assert np.isclose(view.height, HEIGHT) and view.count == view.ranges.size
    places = SampledPlaces(np.array([[3.0, 2.0, 0.0]]), np.eye(3)[None])
    seen = map_ranges(geometry.spatial_index, places, view)
    assert seen.shape == (1, *view.ranges.shape)
    # The lidar's columns are a degree apart, those of the panorama 7.5.
    assert np.median(abs(seen[0] - view.ranges)) < 0.02


def test_a_laser_scan_is_one_row_and_may_be_partial():
    points = np.array([[2.0, 0.0, 0.3], [0.0, 3.0, 0.3]])
    view = panorama_of(points, np.array([0.1, 0.0, 0.3]), 0.0)
    assert view.ranges.shape == (1, 48) and view.count == 2
    assert np.isclose(view.ranges[0, 0], 2) and np.isclose(view.ranges[0, 12], 3)


def test_the_true_heading_scores_best():
    geometry = room()
    places = SampledPlaces(
        np.array([[6.0, 1.5, 0.0], [3.0, 2.0, 0.0]]), np.tile(np.eye(3), (2, 1, 1))
    )
    for steps in (0, 5, 30, 47):
        view = view_of(geometry, turned(3, 2, steps * np.pi / 24))
        seen = map_ranges(geometry.spatial_index, places, view)
        scores = heading_scores(view.ranges, seen, np.full_like(view.ranges, 0.5))
        assert scores.shape == (2, 48)
        assert np.unravel_index(scores.argmax(), scores.shape) == (1, steps)
        assert scores.max() > 0.9


def test_obstacles_cost_less_than_rays_through_walls():
    scan = np.full((1, 48), 4.0, np.float32)
    tolerances = np.full((1, 48), 0.5, np.float32)
    same, before, through, nothing = (
        heading_scores(scan, np.full((1, 1, 48), view, np.float32), tolerances)[0, 0]
        for view in (4.0, 8.0, 2.0, np.inf)
    )
    assert same == 1 and before == nothing and -0.5 < before < 0 and through == -1


def test_directions_without_points_do_not_count():
    scan = np.full((2, 48), np.nan, np.float32)
    scan[1, 3] = 4.0
    views = np.full((1, 2, 48), 9.0, np.float32)
    views[0, 1, 3 + 7] = 4.0
    scores = heading_scores(scan, views, np.full((2, 48), 0.5, np.float32))
    assert scores[0, 7] == 1 and (np.delete(scores[0], 7) < 0).all()
