"""The links of TF from the robot to the map: found among all, and each held to its own age."""

import pytest
from geometry_msgs.msg import TransformStamped
from genpy import Duration, Time
from tf2_py import BufferCore

from mesh_navigation.base.robot import RobotLost
from mesh_navigation.server.robot_chain import AgeLimits, robot_chain, robot_time

LIMITS = AgeLimits("odom", 0.3, 2.0)
ROBOT = ["base_link", "base_footprint", "odom", "map"]


def frames_of(*links):
    """What tf2 tells of these links (parent, child)."""
    buffer = BufferCore(Duration(10))
    for parent, child in links:
        message = TransformStamped(child_frame_id=child)
        message.header.frame_id, message.header.stamp = parent, Time(5)
        message.transform.rotation.w = 1.0
        buffer.set_transform(message, "test")
    return buffer.all_frames_as_yaml()


def test_the_chain_among_other_frames():
    links = [*zip(ROBOT[1:], ROBOT), ("base_link", "arm link: 1"), ("map", "dock")]
    frames = frames_of(*links)
    assert robot_chain(frames, "base_link", "map") == ROBOT
    assert robot_chain(frames, "map", "base_link") == ROBOT[::-1]  # a robot that carries its map
    assert robot_chain(frames, "arm link: 1", "dock") == ["arm link: 1", *ROBOT, "dock"]
    assert robot_chain(frames, "map", "map") == ["map"]


@pytest.mark.parametrize(
    "links, reason",
    [
        ([], "TF has no frame 'base_link'; TF has no frame 'map'"),
        ([("odom", "base_link")], "TF has no frame 'map'"),
        ([("odom", "base_link"), ("earth", "map")], "two trees, from 'odom' and from 'earth'"),
        ([("base_link", "odom"), ("odom", "base_link")], "TF has no frame 'map'"),  # a circle
    ],
)
def test_frames_that_are_not_linked(links, reason):
    with pytest.raises(RobotLost, match=f"from 'base_link' to 'map': .*{reason}"):
        robot_chain(frames_of(*links), "base_link", "map")


@pytest.mark.parametrize(
    "frames, stamps, time",
    [
        (ROBOT, (0.0, 99.8, 98.5), 99.8),
        (ROBOT, (99.9, 99.8, 101.9), 99.8),  # a localizer that stamps ahead
        (ROBOT, (0.0, 100.2, 99.0), 100.2),
        (ROBOT, (0.0, 0.0, 0.0), 100.0),  # a robot that stands for ever
        (ROBOT, (0.0, 99.9, 0.0), 99.9),
        (["base_link", "map"], (99.8,), 99.8),
        (["base_link", "odom"], (99.8,), 99.8),  # the map is the odometry's
        (["odom", "map"], (99.8,), 99.8),
        (["map"], (), 100.0),
    ],
)
def test_the_time_of_the_pose(frames, stamps, time):
    assert robot_time(frames, stamps, 100.0, LIMITS) == time


@pytest.mark.parametrize(
    "frames, stamps, words",
    [
        (ROBOT, (0.0, 99.6, 99.9), r"'base_footprint' in 'odom' is 0\.40 s old.*\(odom_timeout\)"),
        (ROBOT, (99.6, 99.9, 99.9), r"'base_link' in 'base_footprint' is 0\.40 s old"),
        (ROBOT, (0.0, 100.4, 99.9), r"0\.40 s ahead of time, allowed are 0\.30 s \(odom_timeout\)"),
        (ROBOT, (0.0, 99.9, 97.5), r"'odom' in 'map' is 2\.50 s old.* 2\.00 s \(map_timeout\)"),
        (ROBOT, (0.0, 99.9, 102.5), r"2\.50 s ahead of time.*\(map_timeout\)"),
        # Where nothing else moves, the localizer is odometry.
        (["base_link", "map"], (99.6,), r"odom_timeout"),
        (["odom", "map"], (99.6,), r"odom_timeout"),
        (ROBOT, (0.0, 0.0, 99.6), r"'odom' in 'map' is 0\.40 s old.*odom_timeout"),
    ],
)
def test_links_that_are_too_old(frames, stamps, words):
    with pytest.raises(RobotLost, match=words):
        robot_time(frames, stamps, 100.0, LIMITS)
