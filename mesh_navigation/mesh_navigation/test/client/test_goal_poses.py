"""Goals as users give them."""

import math

import pytest
from fake_mbf_server import path_along
from geometry_msgs.msg import Pose, PoseStamped

from mesh_navigation.base.messages import pose_from_message
from mesh_navigation.client.goal_poses import goal_pose, has_heading, heading_of_arrival


def numbers(message):
    pose = pose_from_message(message.pose)
    return [*pose.position, *pose.orientation]


TURNED = [0.0, 0.0, math.sin(0.25), math.cos(0.25)]
UPRIGHT = [0.0, 0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    "goal, fields, expected, heading",
    [
        ((1, 2, 3), {}, [1, 2, 3, *UPRIGHT], False),
        ((1, 2, 3, 0.5), {}, [1, 2, 3, *TURNED], True),
        ((1, 2, 3), {"yaw": 0.5}, [1, 2, 3, *TURNED], True),
        (((1, 2, 3),), {}, [1, 2, 3, *UPRIGHT], False),
        (([1, 2, 3],), {"yaw": 0.0}, [1, 2, 3, *UPRIGHT], True),
        (([1, 2, 3, 0.5],), {}, [1, 2, 3, *TURNED], True),
        ((1, 2, 3, 0.0), {}, [1, 2, 3, *UPRIGHT], True),
    ],
)
def test_numbers(goal, fields, expected, heading):
    message = goal_pose(*goal, frame_id="odom", **fields)
    assert message.header.frame_id == "odom"
    assert numbers(message) == pytest.approx(expected, abs=1e-15)
    assert has_heading(*goal, **fields) == heading


def test_poses_stay_as_they_are():
    stamped = PoseStamped()
    stamped.header.frame_id = "base_link"
    assert goal_pose(stamped, frame_id="map") is stamped
    pose = Pose()
    pose.position.x = 5.0
    message = goal_pose(pose, frame_id="odom")
    assert message.pose is pose and message.header.frame_id == "odom"
    assert has_heading(stamped) and has_heading(pose)


@pytest.mark.parametrize(
    "goal", [(), (1, 2), (1, 2, 3, 4, 5), (1, 2, math.nan), (1, 2, 3, math.inf), ((1, 2),)]
)
def test_what_is_no_goal(goal):
    with pytest.raises(ValueError, match="a goal is x, y, z"):
        goal_pose(*goal)


def test_two_headings_are_one_too_many():
    with pytest.raises(ValueError, match="a goal is x, y, z"):
        goal_pose(1, 2, 3, 4, yaw=0.5)


@pytest.mark.parametrize(
    "points, expected",
    [
        ([(0, 0), (1, 0), (1, 2)], math.pi / 2),
        ([(0, 0), (-1, 0), (-1, 0), (-1, 1e-5)], math.pi),
        ([(1, 1)], None),
        ([(1, 1), (1, 1)], None),
        ([], None),
    ],
)
def test_the_heading_of_arrival(points, expected):
    found = heading_of_arrival(path_along(*points))
    assert found == (None if expected is None else pytest.approx(expected, abs=1e-4))
