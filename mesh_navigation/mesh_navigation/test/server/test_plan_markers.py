"""The markers of a plan."""

import genpy
import numpy as np
from visualization_msgs.msg import Marker

from mesh_msgs import zoo
from navigation_test_maps import MapWithCosts, planner_on

from mesh_navigation.base.pose import Pose
from mesh_navigation.plugins.planner import PlanResult
from mesh_navigation.server.plan_markers import plan_markers

MAP = MapWithCosts(zoo.grid())
STAMP = genpy.Time(3)
NAMES = {"start_point", "start_face", "plan_start", "goal_point", "goal_face", "plan_goal"}


def markers(ends, result):
    made = {name: make() for name, make in plan_markers(MAP, ends, result, STAMP).items()}
    assert set(made) == NAMES
    for name, marker in made.items():
        assert marker.ns == name and marker.header.frame_id == "map"
        assert marker.header.stamp == STAMP and marker.pose.orientation.w == 1
    return made


def position(marker):
    return [marker.pose.position.x, marker.pose.position.y, marker.pose.position.z]


def test_a_plan_that_succeeds():
    ends = Pose.at([2.1, 2.2, 0.3]), Pose.at([8.1, 8.2, 0])
    made = markers(ends, planner_on(MAP).make_plan(*ends))
    assert {marker.action for marker in made.values()} == {Marker.ADD}
    assert position(made["start_point"]) == [2.1, 2.2, 0.3]
    assert np.allclose(position(made["plan_start"]), [2.1, 2.2, 0])
    assert np.allclose(position(made["plan_goal"]), [8.1, 8.2, 0])
    for name, pose in (("start_face", ends[0]), ("goal_face", ends[1])):
        corners = np.array([[point.x, point.y, point.z] for point in made[name].points])
        assert made[name].type == Marker.TRIANGLE_LIST and np.allclose(corners[:, 2], 0.01)
        low, high = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
        assert np.all(low <= pose.position[:2]) and np.all(pose.position[:2] <= high)
    assert (made["goal_point"].color.r, made["goal_point"].color.g) == (1, 0)


def test_what_there_is_not_is_taken_away():
    failed = PlanResult(54, "no path")
    made = markers((Pose.at([2.1, 2.2, 0.3]), Pose.at([80, 8, 0])), failed)
    gone = {name for name, marker in made.items() if marker.action == Marker.DELETE}
    assert gone == {"plan_start", "plan_goal", "goal_face"}
    assert {marker.action for marker in markers(None, failed).values()} == {Marker.DELETE}
    nowhere = Pose.at([np.nan, 0, 0])
    gone = markers((nowhere, nowhere), failed)
    assert {marker.action for marker in gone.values()} == {Marker.DELETE}
