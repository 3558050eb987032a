"""What the node tells, as messages, and how it reads parameters."""

import math

import numpy as np
import pytest
from genpy import Time
from geometry_msgs.msg import Point, Pose, Quaternion
from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import read_parameters
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.registration.rigid import motion
from mesh_msgs import validation, zoo
from mesh_msgs.point_cloud import cloud_rows

from mesh_localization.node.messages import (
    cloud_message,
    matched_cloud,
    pose_matrix,
    pose_message,
    state_message,
    transform_message,
)
from mesh_localization.node.parameters import (
    LASER_SCAN,
    PARAMETERS,
    POINT_CLOUD,
    SensorSource,
    check_frames,
    sensor_sources,
    start_of,
    tracking_options,
)
from mesh_localization.node.session import Report
from mesh_localization.node.through_counts import ThroughCounts
from mesh_localization.tracking.localizer import (
    BaseScan,
    Estimate,
    TrackingOptions,
    TrackingState,
)
from mesh_localization.tracking.ray_fates import RayFate, ray_fates

POSE = motion(np.array([1.0, 2.0, 3.0, 0.0, 0.0, math.pi / 2]))
STAMP = Time(9, 5)
DOWN = np.array([[0.5, 0.5, -0.4], [0.5, 0.6, -1.0], [0.6, 0.5, -1.5], [0.5, 0.5, 1.0]])
"""Rays from 1 m above a floor: before it, on it, through it, off the map."""


@pytest.fixture(scope="module")
def floor():
    mesh = zoo.grid()  # 10 m x 10 m, at the height 0
    geometry = MeshGeometry(mesh.vertices, mesh.faces)
    return PlaneTarget(geometry.spatial_index, geometry.face_normals)


def estimate(fates=None, pose=POSE):
    covariance = np.diag([0.01, 0.04, 0.01, 0.001, 0.001, 0.004])
    state = TrackingState.OK
    return Estimate(pose, covariance, np.eye(4), state, "", fates, STAMP.to_sec())


def test_a_pose_has_its_covariance_about_the_axes_of_the_map():
    message = pose_message(estimate(), "map", STAMP)
    assert (message.header.frame_id, message.header.stamp) == ("map", STAMP)
    np.testing.assert_allclose(pose_matrix(message.pose.pose), POSE, atol=1e-12)
    covariance = np.reshape(message.pose.covariance, (6, 6))
    np.testing.assert_allclose(np.diag(covariance)[:3], [0.04, 0.01, 0.01], atol=1e-12)


def test_a_transform_leads_from_odometry_to_the_map():
    message = transform_message("map", "odom", POSE, STAMP)
    assert (message.header.frame_id, message.child_frame_id) == ("map", "odom")
    place = message.transform.translation
    assert (place.x, place.y, place.z) == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("wrong", [(0, 0, 0, 0), (math.nan, 0, 0, 1), (math.inf, 0, 0, 0)])
def test_poses_that_are_none_are_refused(wrong):
    with pytest.raises(MeshMapError):
        pose_matrix(Pose(Point(1, 2, 3), Quaternion(*wrong)))
    with pytest.raises(MeshMapError):
        pose_matrix(Pose(Point(math.nan, 2, 3), Quaternion(0, 0, 0, 1)))


@pytest.mark.parametrize(
    "report",
    [
        Report(TrackingState.LOST, "there is no map yet"),
        Report(TrackingState.OK, "", estimate(), 0.9, 0.01),
    ],
)
def test_states_are_valid(report):
    message = state_message(report, "map", STAMP)
    assert validation.localization_state(message) == []
    assert message.state == int(report.state)


def test_matched_points_have_residuals_and_unexplained_ones_do_not_meet_the_map(floor):
    pose = motion(np.array([5.0, 5.0, 1.0, 0.0, 0.0, 0.0]))
    points = np.array([0.0, 0.0, 0.0]) + DOWN
    fates = ray_fates(floor, points, np.zeros(3), pose, 0.1)
    expected = [RayFate.BEFORE, RayFate.EXPLAINED, RayFate.THROUGH, RayFate.OFF_MAP]
    assert fates.fates.tolist() == expected
    rows = cloud_rows(matched_cloud(points, estimate(fates, pose), "map", STAMP))
    assert rows["fate"].tolist() == [1, 0, 2]
    np.testing.assert_allclose(rows["residual"], [0.6, 0.0, 0.5], atol=1e-6)
    np.testing.assert_allclose(rows["z"], [0.6, 0.0, -0.5], atol=1e-6)


def test_rays_through_the_map_are_counted_where_it_was(floor):
    pose = motion(np.array([5.0, 5.0, 1.0, 0.0, 0.0, 0.0]))
    counts = ThroughCounts()
    scan = BaseScan(DOWN, np.zeros(3), 0.0)
    fates = ray_fates(floor, DOWN, np.zeros(3), pose, 0.1)
    for _ in range(3):
        counts.add(floor, scan, fates, pose)
    places, numbers = counts.cells()
    assert numbers.tolist() == [3]
    met = pose[:3, 3] + DOWN[2] / 1.5
    assert (np.abs(places[0] - met) <= 0.25 + 1e-6).all()
    counts.clear()
    assert len(counts.cells()[0]) == 0 and counts.changes == 4


def test_clouds_have_the_fields_that_they_are_given():
    points = np.arange(6.0).reshape(2, 3)
    more = {"count": np.array([1, 2], np.uint32), "residual": np.array([0.5, 1], np.float32)}
    rows = cloud_rows(cloud_message(points, more, "map", STAMP))
    assert rows["count"].tolist() == [1, 2] and rows["residual"].tolist() == [0.5, 1.0]
    np.testing.assert_allclose(np.stack([rows[axis] for axis in "xyz"], axis=1), points)
    assert len(cloud_rows(cloud_message(points[:0], {}, "map", STAMP))) == 0


def values_of(**given):
    values, complaints = read_parameters(PARAMETERS, given)
    assert not complaints
    return values


def test_defaults_are_those_of_the_core():
    assert tracking_options(values_of()) == TrackingOptions(base_height=0.0)


def test_one_sensor_or_several():
    assert sensor_sources(values_of(), {}) == [SensorSource("cloud", "cloud", POINT_CLOUD)]
    given = {"front": {"topic": "/f", "data_type": "LaserScan"}, "back": {}}
    values = values_of(observation_sources="front back")
    assert sensor_sources(values, given) == [
        SensorSource("front", "/f", LASER_SCAN),
        SensorSource("back", "back", POINT_CLOUD),
    ]


@pytest.mark.parametrize("given", [{"front": 3}, {"front": {"data_type": "Image"}}])
def test_what_is_no_sensor_is_refused(given):
    with pytest.raises(MeshMapError, match="sensor front of observation_sources"):
        sensor_sources(values_of(observation_sources="front"), given)


def test_frames_have_to_make_a_chain():
    check_frames(values_of())
    for odd in ({"odom_frame_id": "base_link"}, {"base_frame_id": ""}, {"global_frame_id": "odom"}):
        with pytest.raises(MeshMapError, match="make no chain"):
            check_frames(values_of(**odd))


def test_a_start_by_parameters():
    assert start_of(values_of(), {}) is None
    for odd in (math.nan, math.inf, "here"):  # refused, and then told nothing
        assert start_of(values_of(), {"initial_pose_x": odd}) is None
    given = {"initial_pose_x": 3.0, "initial_pose_a": math.pi / 2}
    start = start_of(values_of(**given), given)
    np.testing.assert_allclose(start.pose[:3, 3], [3.0, 0.0, 0.0])
    np.testing.assert_allclose(start.pose[:3, 0], [0.0, 1.0, 0.0], atol=1e-12)
