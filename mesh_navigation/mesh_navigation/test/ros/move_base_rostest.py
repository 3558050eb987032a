#!/usr/bin/python3
"""The action move_base, asked by a real actionlib client, with plugins that fail as told."""

import math
import os
import random
import time
import unittest

import actionlib
import numpy as np
import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from dynamic_reconfigure.client import Client as ReconfigureClient
from flat_robot import FlatRobot
from geometry_msgs.msg import Point, PointStamped
from mbf_msgs.msg import (
    ExePathActionFeedback,
    ExePathActionResult,
    GetPathActionResult,
    MoveBaseAction,
    MoveBaseActionFeedback,
    MoveBaseActionResult,
    MoveBaseGoal,
    RecoveryActionResult,
)
from mbf_msgs.srv import CheckPoint, CheckPointResponse
from sensor_msgs.msg import PointCloud2
from sensor_msgs.point_cloud2 import create_cloud_xyz32
from server_process import TESTS, TIMEOUT, ServerProcess, answer, stamped, write_map
from std_msgs.msg import Header
from std_srvs.srv import Empty, Trigger

from mesh_msgs import zoo
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected

ODD = TESTS / "odd_move_base"
MAP = {"mesh_file": write_map(zoo.grid()), "layers": []}
LISTS = {
    "planners": {
        "line": "0",
        "no_plan": "54",
        "no_goal": "53",
        "off_map": "61",
        "second_time": "54 0",
        "fickle": "0 54 54",
        "long": "0",
    },
    "controllers": {"straight": "0", "collides": "104", "tf_less": "111", "retries": "106 0"},
    "recovery_behaviors": {"calm": "0", "fails": "150", "impassable": "158", "own": "171"},
}
TYPES = {"planners": "odd/Line", "controllers": "odd/Straight", "recovery_behaviors": "odd/Behave"}
HOME = (5.0, 5.0)


def parameters():
    """Of a server with one plugin for each list of outcomes."""
    values = {}
    for kind, plugins in LISTS.items():
        values[kind] = [{"name": name, "type": TYPES[kind]} for name in plugins]
        values.update({name: {"outcomes": outcomes} for name, outcomes in plugins.items()})
    values["controllers"].append({"name": "stands", "type": TYPES["controllers"]})
    values["stands"] = {"speed": 0.0}
    values["long"]["seconds"] = 1000.0
    values["recovery_behaviors"].append({"name": "endless", "type": TYPES["recovery_behaviors"]})
    values["endless"] = {"seconds": 1000.0}
    return {
        **values,
        "mesh_map": MAP,
        "tf_timeout": 3.0,
        "odom_timeout": 3.0,
        "controller_max_retries": 0,
        "planner_patience": 0.0,
        "recovery_patience": 1.0,
    }


def client_of(server):
    client = actionlib.ActionClient(f"/{server.name}/move_base", MoveBaseAction)
    assert client.wait_for_server(TIMEOUT)
    return client


def walled_parameters():
    """Of a server with a wall across x = 7, with a door of 2 m at y = 5, and one round a corner."""
    mesh = zoo.grid(cells=50, size=10.0)
    x, y, _ = mesh.vertices.T
    wall = (np.abs(x - 7.0) < 0.05) & (np.abs(y - 5.0) > 1.0)
    wall |= np.abs(np.maximum(x, y) - 2.0) < 0.05
    mesh.vertices[wall, 2] = 0.25
    return {
        **parameters(),
        "planners": [{"name": "waves", "type": "wave_front_planner/WaveFrontPlanner"}],
        "mesh_map": {
            "mesh_file": write_map(mesh),
            "layers": [
                {"name": "walls", "type": "mesh_layers/HeightDiffLayer"},
                {"name": "obstacles", "type": "mesh_layers/ObstacleLayer"},
            ],
            "walls": {"radius": 0.5},
            "obstacles": {
                "topic": "/cloud",
                "sensor_frame": "map",
                "decay": 0,
                "clearing": False,
                "expected_update_rate": 0,
                "max_obstacle_dist": 50.0,
            },
        },
    }


def is_busy(action, server="server"):
    """Whether a sub-goal of move_base is active there."""
    statuses = rospy.wait_for_message(f"/{server}/{action}/status", GoalStatusArray, 60).status_list
    active = [status.goal_id.id for status in statuses if status.status == GoalStatus.ACTIVE]
    return any(each.startswith("move_base") for each in active)


class MoveBaseTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        os.environ["ROS_PACKAGE_PATH"] = f"{ODD}:{os.environ['ROS_PACKAGE_PATH']}"
        os.environ["PYTHONPATH"] = f"{ODD / 'src'}:{os.environ['PYTHONPATH']}"
        cls.robot = FlatRobot(*HOME)
        cls.server = ServerProcess("server", **parameters())
        cls.client = client_of(cls.server)
        cls.reconfigure = ReconfigureClient("/server", timeout=60)
        cls.ends = {"get_path": [], "exe_path": [], "recovery": [], "move_base": []}
        cls.subscribers = [
            rospy.Subscriber(f"/server/{action}/result", kind, cls.ends[action].append)
            for action, kind in (
                ("get_path", GetPathActionResult),
                ("exe_path", ExePathActionResult),
                ("recovery", RecoveryActionResult),
                ("move_base", MoveBaseActionResult),
            )
        ]
        wait_until(lambda: connected(*cls.subscribers), "connections")

    @classmethod
    def tearDownClass(cls):
        try:
            status = cls.server.stop()
        finally:
            cls.server.kill()
            cls.robot.stop()
        assert status == 0, cls.server.output()

    def setUp(self):
        self.robot.x, self.robot.y, self.robot.yaw = *HOME, 0.0
        self.robot.lost = False
        time.sleep(0.2)  # until the server knows; what is late from the last test has come, too
        self.robot.commands.clear()
        for ends in self.ends.values():
            ends.clear()

    def send(self, x=0.6, y=0.0, frame="map", client=None, **fields):
        """Send a goal that far from home."""
        goal = (HOME[0] + x, HOME[1] + y, 0.0) if frame == "map" else (x, y, 0.0)
        message = MoveBaseGoal(target_pose=stamped(goal, frame), **fields)
        return (client or self.client).send_goal(message)

    def check(self, handle, state, outcome, *words):
        found, result = answer(handle)
        self.assertEqual((found, result.outcome), (state, outcome), result.message)
        self.assertTrue(result.message)
        for word in words:
            self.assertIn(word, result.message)
        return result

    def outcomes(self, action):
        """Of the sub-goals that have ended."""
        return [end.result.outcome for end in self.ends[action]]

    def seen(self, **expected):
        """Wait until these sub-goals were seen to end, and no others."""
        for action, outcomes in expected.items():
            wait_until(lambda: len(self.outcomes(action)) >= len(outcomes), action)
            self.assertEqual(self.outcomes(action), outcomes)

    def test_a_goal_beyond_all_distances(self):
        """Farther than the numbers of messages reach."""
        result = self.check(self.send(1e39), "ABORTED", 53, "from the map")
        self.assertEqual(result.dist_to_goal, math.inf)

    def test_arrival(self):
        own, parts = [], []
        subscribers = [
            rospy.Subscriber("/server/move_base/feedback", MoveBaseActionFeedback, own.append),
            rospy.Subscriber("/server/exe_path/feedback", ExePathActionFeedback, parts.append),
        ]
        wait_until(lambda: connected(*subscribers), "connections")
        result = self.check(self.send(0.8, 0.5), "SUCCEEDED", 0)
        self.assertLess(result.dist_to_goal, 0.1)
        self.assertLess(result.angle_to_goal, math.pi / 18)
        self.assertEqual(result.final_pose.header.frame_id, "map")
        position = result.final_pose.pose.position
        self.assertLess(math.hypot(position.x - 5.8, position.y - 5.5), 0.1)
        wait_until(lambda: self.robot.commands and self.robot.stands, "zero velocity")
        self.seen(get_path=[0], exe_path=[0], recovery=[])
        for action in ("get_path", "exe_path"):
            self.assertRegex(self.ends[action][0].status.goal_id.id, "^move_base")
        wait_until(lambda: own and len(own) == len(parts), "feedback")
        for first, second in zip(own, parts):
            for name in type(first.feedback).__slots__:
                pair = getattr(first.feedback, name), getattr(second.feedback, name)
                self.assertEqual(*map(str, pair))
        for subscriber in subscribers:
            subscriber.unregister()

    def test_names_that_nobody_knows(self):
        for fields, outcome in (
            ({"planner": "mistaken"}, 59),
            ({"controller": "mistaken"}, 113),
            ({"recovery_behaviors": ["calm", "mistaken"]}, 155),
        ):
            handle = self.send(**fields)
            result = self.check(handle, "REJECTED", outcome, "'mistaken'", "known: ")
            self.assertEqual(handle.get_goal_status_text(), result.message)
        self.assertEqual(self.ends["get_path"], [])

    def test_goals_that_are_none(self):
        self.check(self.send(math.nan), "ABORTED", 53, "goal: ", "nan")
        self.check(self.send(frame="nowhere"), "ABORTED", 16, "nowhere", "3.0 s")
        self.check(self.send(frame=""), "ABORTED", 16, "no frame_id")
        self.assertEqual(self.ends["get_path"], [])

    def test_a_goal_off_the_map_moves_no_robot(self):
        self.check(self.send(100.0), "ABORTED", 53, "goal (105.00, 5.00, 0.00)", "from the map")
        self.assertEqual(self.ends["recovery"], [])
        self.assertEqual(self.ends["get_path"], [])
        # Of one that is on the map something may be in the way, for now.
        self.check(self.send(planner="no_goal", recovery_behaviors=["calm"]), "ABORTED", 53, "calm")
        self.assertEqual(self.outcomes("recovery"), [0])

    def test_the_log_says_each_thing_once(self):
        text = "plan with 54"
        before = self.server.output().count(text)
        self.check(self.send(planner="no_plan", recovery_behaviors=["fails"]), "ABORTED", 54)
        wait_until(lambda: self.server.output().count(text) > before + 1, "the end in the log")
        time.sleep(0.3)
        # What the recovery is for, and the end.
        self.assertEqual(self.server.output().count(text), before + 2)

    def test_a_goal_in_the_frame_of_the_robot_stays_where_it_was(self):
        self.reconfigure.update_configuration({"planner_frequency": 20.0})
        result = self.check(self.send(0.7, frame="base_link"), "SUCCEEDED", 0)
        self.assertLess(abs(result.final_pose.pose.position.x - 5.7), 0.1)
        self.reconfigure.update_configuration({"planner_frequency": 0.0})

    def test_a_robot_that_is_nowhere(self):
        self.robot.lost = True
        time.sleep(3.5)
        result = self.check(self.send(), "ABORTED", 16, "base_link", "tf_timeout")
        self.assertTrue(math.isnan(result.dist_to_goal))
        self.assertEqual(self.ends["get_path"], [])

    def test_failures_without_recovery(self):
        self.reconfigure.update_configuration({"recovery_enabled": False})
        result = self.check(self.send(3.0, 4.0, planner="no_plan"), "ABORTED", 54, "plan with 54")
        self.assertAlmostEqual(result.dist_to_goal, 5.0, places=3)
        self.assertAlmostEqual(result.final_pose.pose.position.x, HOME[0], places=3)
        self.check(self.send(controller="collides"), "ABORTED", 104, "drive with 104")
        self.reconfigure.update_configuration({"recovery_enabled": True})
        self.seen(get_path=[54, 0], exe_path=[104], recovery=[])

    def test_failures_that_are_final(self):
        self.check(self.send(planner="off_map"), "ABORTED", 61)
        self.check(self.send(controller="tf_less"), "ABORTED", 111)
        self.assertEqual(self.ends["recovery"], [])

    def test_recovery(self):
        self.check(self.send(planner="second_time"), "SUCCEEDED", 0)
        self.seen(get_path=[54, 0], exe_path=[0], recovery=[0])
        self.check(self.send(0.0, controller="retries"), "SUCCEEDED", 0)
        self.seen(get_path=[54, 0, 0, 0], exe_path=[0, 106, 0], recovery=[0, 0])
        self.assertEqual({end.result.used_plugin for end in self.ends["recovery"]}, {"calm"})

    def test_recovery_that_does_not_help(self):
        behaviors = ["calm", "impassable", "own"]
        handle = self.send(planner="no_plan", recovery_behaviors=behaviors)
        self.check(handle, "ABORTED", 54, "plan with 54", "did not help: calm, impassable, own")
        self.seen(get_path=[54, 54, 54], recovery=[0, 158, 171])
        output = self.server.output()
        self.assertIn("planning failed: ", output)
        self.assertIn("recovery impassable failed: ", output)

    def test_all_behaviors_in_their_order_unless_named(self):
        names = [*LISTS["recovery_behaviors"], "endless"]
        self.check(self.send(controller="collides"), "ABORTED", 104, ", ".join(names))
        self.seen(recovery=[0, 150, 158, 171, 152])
        used = [end.result.used_plugin for end in self.ends["recovery"]]
        self.assertEqual(used, names)

    def test_new_plans_while_driving(self):
        self.reconfigure.update_configuration({"planner_frequency": 20.0})
        self.check(self.send(3.0, planner="fickle"), "SUCCEEDED", 0)
        self.reconfigure.update_configuration({"planner_frequency": 0.0})
        wait_until(lambda: self.outcomes("exe_path")[-1:] == [0], "the end")
        self.assertEqual(self.ends["recovery"], [])
        self.assertIn(54, self.outcomes("get_path"))
        # All but the last, or the last two where a plan comes just when the robot has arrived.
        preempted = [end for end in self.ends["exe_path"] if end.result.outcome]
        self.assertGreater(len(preempted), 0)
        self.assertLessEqual(len(self.ends["exe_path"]) - len(preempted), 2)
        texts = {(end.result.outcome, end.result.message) for end in preempted}
        self.assertEqual(texts, {(101, "Goal preempted by a new plan")})
        self.assertNotIn("no new plan", self.server.output())  # some that fail are part of driving

    def test_oscillation(self):
        self.reconfigure.update_configuration({"oscillation_timeout": 0.5})
        fields = {"controller": "stands", "recovery_behaviors": ["calm"]}
        handle = self.send(**fields)
        self.check(handle, "ABORTED", 13, "oscillation_timeout", "did not help: calm")
        self.reconfigure.update_configuration({"oscillation_timeout": 0.0})
        self.seen(recovery=[0], get_path=[0, 0])

    def test_cancel_in_each_stage(self):
        for stage, fields in (
            ("get_path", {"planner": "long"}),
            ("exe_path", {"controller": "stands"}),
            ("recovery endless", {"planner": "no_plan", "recovery_behaviors": ["endless"]}),
        ):
            self.robot.commands.clear()
            handle = self.send(**fields)
            time.sleep(0.3)
            handle.cancel()
            result = self.check(handle, "PREEMPTED", 11, f"canceled during {stage}", "client")
            self.assertAlmostEqual(result.dist_to_goal, 0.6, places=3)
        self.assertFalse([name for name in self.ends if not self.ends[name]])

    def test_the_map_is_replaced_in_each_stage(self):
        """Going on would be driving on another map than the goal was sent for."""
        reload_map = rospy.ServiceProxy("/server/reload_map", Trigger)
        self.reconfigure.update_configuration({"recovery_patience": 0.0})
        for stage, outcome, fields in (
            ("get_path", 62, {"planner": "long"}),
            ("exe_path", 116, {"controller": "stands"}),
            ("recovery", 62, {"planner": "no_plan", "recovery_behaviors": ["endless"]}),
        ):
            handle = self.send(**fields)
            wait_until(lambda: is_busy(stage), f"{stage} of move_base")
            self.assertTrue(reload_map().success)
            self.check(handle, "ABORTED", outcome, "loaded anew")
        self.reconfigure.update_configuration({"recovery_patience": 1.0})
        self.check(self.send(), "SUCCEEDED", 0)

    def test_cancels_at_random_times(self):
        rng, states = random.Random(0), []
        cancel = rospy.Publisher("/server/move_base/cancel", GoalID, queue_size=10)
        wait_until(cancel.get_num_connections, "connection")
        for number in range(100):
            if number % 10 == 0:
                self.robot.x, self.robot.y = HOME
            handle = self.send(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0))
            time.sleep(rng.uniform(0.0, 0.1))
            # As bare messages: actionlib's client forgets goals that it cancels too early.
            cancel.publish(GoalID(id=handle.comm_state_machine.action_goal.goal_id.id))
            state, result = answer(handle)
            states.append((state, result.outcome))
            self.assertTrue(result.message)
        possible = {("PREEMPTED", 11), ("RECALLED", 11), ("SUCCEEDED", 0)}
        self.assertLessEqual(set(states), possible)
        self.assertIn(("PREEMPTED", 11), states)
        wait_until(lambda: self.robot.stands, "zero velocity")
        wait_until(lambda: len(self.ends["move_base"]) == len(states), "one answer each")

    def test_a_newer_goal_replaces_the_older(self):
        older = self.send(controller="stands")
        time.sleep(0.2)
        newer = self.send()
        self.check(older, "PREEMPTED", 11, "newer goal")
        self.check(newer, "SUCCEEDED", 0)

    def test_a_storm_of_goals(self):
        handles = [self.send(0.01 * number) for number in range(50)]
        for handle in handles[:-1]:
            state, result = answer(handle)
            self.assertIn((state, result.outcome), [("PREEMPTED", 11), ("SUCCEEDED", 0)])
        self.check(handles[-1], "SUCCEEDED", 0)
        wait_until(lambda: len(self.ends["move_base"]) == 50, "one answer each")
        self.assertEqual(len({end.status.goal_id.id for end in self.ends["move_base"]}), 50)

    def test_who_cancels_the_drive_stops_the_robot(self):
        """Also when a new plan takes over at that moment."""
        rng = random.Random(1)
        stop = rospy.Publisher("/server/exe_path/cancel", GoalID, queue_size=1)
        wait_until(stop.get_num_connections, "connection")
        self.reconfigure.update_configuration({"planner_frequency": 20.0})
        for _ in range(10):
            handle = self.send(controller="stands")
            rospy.wait_for_message("/server/move_base/feedback", MoveBaseActionFeedback, 60)
            time.sleep(rng.uniform(0.0, 0.1))
            stop.publish(GoalID())
            self.check(handle, "PREEMPTED", 11, "exe_path was canceled, not by move_base")
        self.reconfigure.update_configuration({"planner_frequency": 0.0})

    def test_goals_that_are_blocked_for_good_and_for_now(self):
        """Real planners on a map with a wall: its door is closed by what a sensor sees."""
        walled = ServerProcess("walled", **walled_parameters())
        clouds = rospy.Publisher("/cloud", PointCloud2, queue_size=1)
        check = rospy.ServiceProxy("/walled/check_point_cost", CheckPoint)
        clear = rospy.ServiceProxy("/walled/clear_mesh", Empty)
        ends = {"get_path": [], "recovery": []}
        subscribers = [
            rospy.Subscriber(
                "/walled/get_path/result", GetPathActionResult, ends["get_path"].append
            ),
            rospy.Subscriber(
                "/walled/recovery/result", RecoveryActionResult, ends["recovery"].append
            ),
        ]
        try:
            client = client_of(walled)
            wait_until(lambda: connected(clouds, *subscribers), "connections")
            words = "whatever sensors see, it is blocked by layer walls"
            for x, y, outcome in ((2.0, 3.0, 53), (-4.5, -4.5, 54)):  # the wall, a closed corner
                handle = self.send(x, y, client=client)
                self.check(handle, "ABORTED", outcome, "blocked", words)
            self.assertEqual([end.result.outcome for end in ends["get_path"]], [53, 54])
            place = self.robot.x, self.robot.y, self.robot.yaw
            self.assertEqual((ends["recovery"], place), ([], (*HOME, 0.0)))

            def is_seen():
                places = [(7.05, 0.1 * step, 0.5) for step in range(35, 66)]
                places += [(7.15, y, z) for _, y, z in places]
                header = Header(stamp=rospy.Time.now(), frame_id="map")
                clouds.publish(create_cloud_xyz32(header, places))
                place = PointStamped(header=header, point=Point(7.05, 5.0, 0.0))
                return check(point=place).state == CheckPointResponse.LETHAL

            wait_until(is_seen, "obstacles in the door")
            handle = self.send(3.5, 0.0, client=client)
            wait_until(lambda: is_busy("get_path", "walled"), "a plan that is looked for")
            self.assertTrue(all(is_busy("get_path", "walled") for _ in range(3)))
            self.assertEqual((ends["recovery"], len(ends["get_path"])), ([], 2))
            clear()
            self.check(handle, "SUCCEEDED", 0)
            wait_until(lambda: len(ends["get_path"]) == 3, "the plan")
            self.assertEqual(ends["get_path"][2].result.outcome, 0)
            self.assertEqual(ends["recovery"], [])
            self.assertEqual(walled.stop(), 0)
        finally:
            walled.kill()

    def test_shutdown_and_missing_map(self):
        values = {**parameters(), "mesh_map": {**MAP, "mesh_file": "/nowhere/map.h5"}}
        mapless = ServerProcess("mapless", wait=False, **values)
        other = ServerProcess("other", wait=False, **parameters())
        try:
            self.check(self.send(client=client_of(mapless)), "ABORTED", 62, "/nowhere/map.h5")
            self.assertEqual(mapless.stop(), 0)
            handle = self.send(client=client_of(other), controller="stands")
            rospy.wait_for_message("/other/move_base/feedback", MoveBaseActionFeedback, 60)
            other.terminate()
            self.check(handle, "ABORTED", 117, "shut down")
            self.assertEqual(other.wait(), 0)
        finally:
            mapless.kill()
            other.kill()
        wait_until(lambda: self.robot.stands, "zero velocity")


if __name__ == "__main__":
    rospy.init_node("move_base_rostest")
    rostest.rosrun("mesh_navigation", "move_base", MoveBaseTest)
