#!/usr/bin/python3
"""MeshNavigator, go_to and goal_bridge, with a server that only pretends."""

import json
import math
import random
import re
import signal
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path
from unittest import mock

import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
import fake_mbf_server
from fake_mbf_server import FakeServer, never, path_along
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import (
    ExePathResult,
    GetPathResult,
    MoveBaseFeedback,
    MoveBaseGoal,
    MoveBaseResult,
)
from mesh_msgs.diagnostics_ros import OK
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics
from mesh_navigation import MeshNavigator
from mesh_navigation.base.messages import pose_from_message
from mesh_navigation.client import action_caller_ros
from mesh_navigation.client.navigation_result import NavigationError
from server_process import program, stamped

ACTIVE = (GoalStatus.ACTIVE, GoalStatus.PREEMPTING, GoalStatus.PENDING)


def in_thread(function, *args, **fields):
    """Call a function in a thread; returns the thread and the list for its result."""
    results = []

    def run():
        results.append(function(*args, **fields))

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    return thread, results


# What rospy says of another node that ended while it was about to connect, as commands do here,
# and what commands say where their connections take longer than a second.
BUSY = re.compile(
    r"\[WARN\].*Inbound TCP/IP connection failed: connection from sender.*\n"
    r"|.*waiting for the action server /move_base_flex/(?!move_base, then for goals).*\n"
)


class Command:
    """A node of the package as a process; its output goes to files."""

    def __init__(self, *words):
        self.out, self.err = (tempfile.NamedTemporaryFile("r") for _ in range(2))
        with open(self.out.name, "w") as out, open(self.err.name, "w") as err:
            self.process = subprocess.Popen(words, stdout=out, stderr=err)

    def texts(self):
        """Standard output and standard error so far."""
        errors = Path(self.err.name).read_text()
        return BUSY.sub("", Path(self.out.name).read_text()), BUSY.sub("", errors)

    def wait_for(self, text):
        """Wait until the process has said that."""
        try:
            wait_until(lambda: text in "".join(self.texts()), repr(text))
        except AssertionError as error:
            raise AssertionError(f"{error}, but {self.texts()}") from None

    def end(self):
        """(code, output, errors) when the process has ended."""
        try:
            return (self.process.wait(60), *self.texts())
        finally:
            self.kill()

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait(30)


def go_to(*words):
    return Command(program("mesh_navigation", "go_to"), *map(str, words))


class ClientsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = FakeServer("/move_base_flex")
        cls.navigator = MeshNavigator()
        cls.navigator.wait_until_ready(timeout=60)

    def setUp(self):
        self.server.answers.clear()
        for handles in self.server.goals.values():
            handles.clear()
        self.server.canceled.clear()

    def newest(self, action):
        """The goal that the server got last."""
        return self.server.goals[action][-1].get_goal()

    def wait_for_goal(self, action="move_base", count=1):
        wait_until(lambda: len(self.server.goals[action]) >= count, f"goal {count} of {action}")

    def assert_nothing_is_left(self):
        for handles in self.server.goals.values():
            for handle in handles:
                self.assertNotIn(handle.get_goal_status().status, ACTIVE)

    def test_fields_and_feedback(self):
        def drive(handle):
            for distance in (3.0, 2.0):
                handle.publish_feedback(MoveBaseFeedback(dist_to_goal=distance))
            wait_until(lambda: len(feedback) == 2, "the feedback")
            result = MoveBaseResult(message="there", dist_to_goal=0.5)
            handle.set_succeeded(result)

        feedback = []
        self.server.answers["move_base"] = drive
        result = self.navigator.go_to(
            stamped((1, 2, 3), "odom"),
            planner="p",
            controller="c",
            recovery_behaviors=("a", "b"),
            on_feedback=feedback.append,
        )
        self.assertEqual(str(result), "SUCCESS (0): there")
        self.assertTrue(result.succeeded)
        self.assertEqual(result.details.dist_to_goal, 0.5)
        self.assertEqual([each.dist_to_goal for each in feedback], [3.0, 2.0])
        goal = self.newest("move_base")
        self.assertEqual((goal.planner, goal.controller), ("p", "c"))
        self.assertEqual(goal.recovery_behaviors, ["a", "b"])
        self.assertEqual(goal.target_pose.header.frame_id, "odom")
        self.assertEqual(self.server.goals["get_path"], [])

    def test_a_place_keeps_the_heading_of_arrival(self):
        path = path_along((0, 0), (1, 0), (1, 2))
        self.server.answers["get_path"] = lambda handle: handle.set_succeeded(
            GetPathResult(path=path)
        )
        self.assertTrue(self.navigator.go_to(1, 2, 3, planner="p").succeeded)
        self.assertEqual(self.newest("get_path").planner, "p")
        self.assertEqual(self.newest("get_path").concurrency_slot, 255)
        pose = pose_from_message(self.newest("move_base").target_pose.pose)
        self.assertEqual(pose.position.tolist(), [1, 2, 3])
        self.assertAlmostEqual(math.atan2(*pose.heading[1::-1]), math.pi / 2)
        self.assertTrue(self.navigator.go_to(1, 2, 3, yaw=0.25).succeeded)
        self.assertEqual(len(self.server.goals["get_path"]), 1)

    def test_a_place_without_a_plan_is_left_to_move_base(self):
        self.server.answers["get_path"] = lambda handle: handle.set_aborted(
            GetPathResult(outcome=GetPathResult.NO_PATH_FOUND, message="no way")
        )
        self.server.answers["move_base"] = lambda handle: handle.set_aborted(
            MoveBaseResult(outcome=GetPathResult.NO_PATH_FOUND, message="still no way")
        )
        result = self.navigator.go_to(1, 2, 3)
        self.assertEqual(
            (result.succeeded, str(result)), (False, "NO_PATH_FOUND (54): still no way")
        )

    def test_the_other_actions(self):
        path = path_along((0, 0), (1, 0))
        self.server.answers["get_path"] = lambda handle: handle.set_succeeded(
            GetPathResult(path=path)
        )
        found = self.navigator.get_path((1, 0, 0), start=(0, 0, 0, 0.5), tolerance=0.25).details
        goal = self.newest("get_path")
        self.assertEqual((goal.use_start_pose, goal.tolerance), (True, 0.25))
        self.assertEqual(goal.concurrency_slot, 1)
        self.assertAlmostEqual(goal.start_pose.pose.orientation.z, math.sin(0.25))
        for tolerances in ((), (0.5, 0.25)):
            self.assertTrue(self.navigator.follow_path(found.path, "c", *tolerances).succeeded)
            goal = self.newest("exe_path")
            self.assertEqual((goal.controller, len(goal.path.poses)), ("c", 2))
            given = goal.tolerance_from_action, goal.dist_tolerance, goal.angle_tolerance
            self.assertEqual(given, (True, *tolerances) if tolerances else (False, 0.0, 0.0))
        with self.assertRaisesRegex(ValueError, "give both"):
            self.navigator.follow_path(found.path, dist_tolerance=0.5)
        self.assertTrue(self.navigator.recover("wait").succeeded)
        self.assertEqual(self.newest("recovery").behavior, "wait")

    def test_failures_are_results(self):
        def answer(handle):
            handle.set_aborted(ExePathResult(outcome=130, message="odd"))

        self.server.answers["exe_path"] = answer
        result = self.navigator.follow_path(path_along((0, 0)))
        self.assertEqual(str(result), "CONTROLLER_ERROR (130): odd")
        self.assertFalse(result.succeeded)

    def test_a_timeout_cancels(self):
        self.server.answers["move_base"] = never
        result = self.navigator.go_to(stamped((1, 2, 3)), timeout=0.5)
        self.assertEqual(str(result), "CANCELED (11): no result within 0.5 s: stopped")
        self.assertFalse(result.succeeded)
        self.assert_nothing_is_left()

    def test_cancel_at_random_times(self):
        self.server.answers["move_base"] = never
        random.seed(0)
        outcomes = []
        for number in range(150):
            thread, results = in_thread(self.navigator.go_to, stamped((1, 2, 3)))
            time.sleep(random.choice([0.0, 0.0002, 0.001, 0.003, 0.01]))

            def ended():  # it may not have begun when the first cancel comes
                self.navigator.cancel()
                return not thread.is_alive()

            wait_until(ended, f"the end of goal {number}", 30)
            (result,) = results
            self.assertEqual((result.name, result.succeeded), ("CANCELED", False), result)
            self.assertTrue(result.message)
            outcomes.append(result.outcome)
        self.assertEqual(set(outcomes), {11})
        self.assert_nothing_is_left()

    def test_a_cancel_between_plan_and_drive(self):
        def plan(handle):
            self.navigator.cancel()

        self.server.answers["get_path"] = plan
        result = self.navigator.go_to(1, 2, 3)
        self.assertEqual((result.outcome, result.name), (11, "CANCELED"))
        self.assertEqual(self.server.goals["move_base"], [])

    def test_many_threads(self):
        def answer(handle):
            time.sleep(random.random() / 50)
            x = handle.get_goal().target_pose.pose.position.x
            handle.set_succeeded(GetPathResult(cost=x, message="m"))

        self.server.answers["get_path"] = answer
        found = {x: in_thread(self.navigator.get_path, x, 0, 0) for x in range(60)}
        for x, (thread, results) in found.items():
            thread.join(60)
            self.assertEqual(results[0].details.cost, x)

    def test_no_server(self):
        told = []
        navigator = MeshNavigator("nobody", told.append)
        text = r"no action server /nobody/move_base within 1\.5 s \(there are: .*/move_base_flex\)"
        with self.assertRaisesRegex(NavigationError, text):
            navigator.go_to(1, 2, 3, 0.5, timeout=1.5)
        (line,) = told
        self.assertIn("waiting for the action server /nobody/move_base (there are: ", line)

    def test_a_server_that_dies_and_one_that_starts_anew(self):
        def start():
            server = Command("/usr/bin/python3", fake_mbf_server.__file__, "/mortal")
            self.addCleanup(server.kill)
            server.wait_for("ready")
            return server

        def patience(**seconds):
            for name, value in seconds.items():
                patch = mock.patch.object(action_caller_ros, name, value)
                patch.start()
                self.addCleanup(patch.stop)

        patience(SILENCE=1.0, UNKNOWN=2.0)  # shorter than they are
        server = start()
        navigator = MeshNavigator("mortal")
        goal = stamped((1, 2, 3))
        for again in (False, True):
            if again:  # however long the start takes, silence does not end it
                patience(SILENCE=100.0)
            feedback, errors = [], []

            def go():
                try:
                    navigator.go_to(goal, on_feedback=feedback.append)
                except NavigationError as error:
                    errors.append(str(error))

            thread = threading.Thread(target=go, daemon=True)
            thread.start()
            wait_until(lambda: feedback or errors, "the goal's feedback")
            self.assertEqual(errors, [])
            server.kill()
            if again:
                server = start()
            thread.join(60)
            text = "does not know the goal" if again else "the server has ended"
            self.assertIn(text, errors[0])
            if not again:
                server = start()
                wait_until(lambda: navigator._goals.has_server("move_base"), "the new server")
        result = navigator.go_to(goal, timeout=1.0)
        self.assertEqual(result.name, "CANCELED")

    def test_the_command(self):
        path = path_along((0, 0), (3, 0), (3, 4))
        self.server.answers["get_path"] = lambda handle: handle.set_succeeded(
            GetPathResult(path=path, cost=9.0, message="found")
        )
        planned = go_to("3", "-4", "-1e-3", "--plan-only", "--json")
        driven = go_to(1, 2, 3, 90, "--controller", "c", "--recovery", "a")
        code, out, err = planned.end()
        self.assertEqual((code, err), (0, ""))
        self.assertEqual(json.loads(out)["length"], 7.0)
        self.assertEqual(self.newest("get_path").target_pose.pose.position.z, -1e-3)
        code, out, err = driven.end()
        self.assertEqual((code, err, out.split("\n")[0]), (0, "", "SUCCESS (0): well done"))
        goal = self.newest("move_base")
        self.assertEqual((goal.controller, goal.recovery_behaviors), ("c", ["a"]))
        self.assertAlmostEqual(goal.target_pose.pose.orientation.z, math.sqrt(0.5))

    def test_failures_of_the_command(self):
        self.server.answers["move_base"] = lambda handle: handle.set_aborted(
            MoveBaseResult(outcome=109, message="blocked")
        )
        failed, lonely = go_to(1, 2, 3, 0), go_to(1, 2, 3, "--server", "nobody", "--timeout", 1)
        code, out, err = failed.end()
        self.assertEqual((code, err, out.split("\n")[0]), (1, "", "BLOCKED_PATH (109): blocked"))
        code, out, err = lonely.end()
        self.assertEqual((code, out), (2, ""))
        self.assertIn("go_to: error: no action server /nobody/get_path within 1.0 s", err)

    def test_the_command_tells_what_it_waits_for_and_what_it_does_not_know(self):
        self.server.answers["get_path"] = lambda handle: handle.set_aborted(
            GetPathResult(outcome=51, message="no\nway")
        )
        waiting, headless = go_to(1, 2, 3, 0, "--server", "late"), go_to(1, 2, 3)
        code, out, err = headless.end()
        self.assertEqual((code, out.split("\n")[0]), (0, "SUCCESS (0): well done"))
        self.assertEqual(err, "go_to: the heading of arrival is not known: no way\n")
        told = "go_to: waiting for the action server /late/get_path (there are: "
        waiting.wait_for(told)
        FakeServer("/late")
        code, out, err = waiting.end()
        self.assertEqual((code, out.split("\n")[0]), (0, "SUCCESS (0): well done"))
        self.assertTrue(err.startswith(told), err)
        late = "go_to: waiting for the action server /late/"  # move_base's may take longer, too
        self.assertEqual([line for line in err.splitlines() if not line.startswith(late)], [])

    def test_ctrl_c_cancels(self):
        self.server.answers["move_base"] = never
        commands = [(number, go_to(1, 2, 3, 0)) for number in (signal.SIGINT, signal.SIGTERM)]
        self.wait_for_goal(count=2)
        for count, (number, command) in enumerate(commands, 1):
            command.process.send_signal(number)
            code, out, err = command.end()
            self.assertEqual((code, err), (130, ""), out)
            self.assertIn("CANCELED (11): stopped", out)
            self.assertEqual(len(self.server.canceled), count)

    def test_ctrl_c_in_a_program(self):
        go = "MeshNavigator().go_to(1, 2, 3, 0)"
        of_its_own = f"try:\n    {go}\nexcept KeyboardInterrupt:\n    print('interrupted')\n"
        rospys = f"import rospy\nrospy.init_node('program')\nprint({go}.name)\n"
        self.server.answers["move_base"] = never
        first = "from mesh_navigation import MeshNavigator\n"
        commands = [
            (printed, Command("/usr/bin/python3", "-c", first + text))
            for text, printed in ((of_its_own, "interrupted\n"), (rospys, "CANCELED\n"))
        ]
        self.wait_for_goal(count=2)
        for count, (printed, command) in enumerate(commands, 1):
            command.process.send_signal(signal.SIGINT)
            self.assertEqual(command.end(), (0, printed, ""))
            self.assertEqual(len(self.server.canceled), count)

    def test_names_that_are_none(self):
        with self.assertRaisesRegex(ValueError, "'a b' is no name of a node"):
            MeshNavigator("a b")
        with self.assertRaisesRegex(ValueError, "'fly' is none of get_path, exe_path"):
            self.navigator.wait_until_ready("fly")

    def test_the_bridge(self):
        words = "_goal_topic:=/clicked", "_controller:=c", "_recovery_behaviors:=[a]"
        diagnostics = HeardDiagnostics()
        bridge = Command(program("mesh_navigation", "goal_bridge"), *words)
        self.addCleanup(bridge.kill)
        clicks = rospy.Publisher("/clicked", PoseStamped, queue_size=10)
        wait_until(lambda: clicks.get_num_connections(), "the bridge")

        bridge.wait_for(
            "waiting for the action server /move_base_flex/move_base, then for goals on /clicked"
        )

        def click_until_sent():  # its first goals may come before it is connected
            clicks.publish(stamped((1, 2, 3)))
            time.sleep(0.1)
            return self.server.goals["move_base"]

        self.server.answers["move_base"] = never
        wait_until(click_until_sent, "a goal")
        diagnostics.expected(
            "goal_bridge: goals", OK, "goals are sent to /move_base_flex/move_base"
        )
        self.assertEqual(self.newest("move_base").controller, "c")
        self.assertEqual(self.newest("move_base").recovery_behaviors, ["a"])
        before = len(self.server.goals["move_base"])

        # Chosen in RViz, by who came before or after the bridge; what is not chosen stays.
        chosen = rospy.Publisher(
            "/move_base_flex/goal_defaults", MoveBaseGoal, queue_size=1, latch=True
        )
        chosen.publish(MoveBaseGoal(planner="p"))
        bridge.wait_for("from now on planner p and controller c")
        clicks.publish(stamped((2, 2, 2)))
        self.wait_for_goal(count=before + 1)
        newest = self.newest("move_base")
        self.assertEqual((newest.planner, newest.controller), ("p", "c"))
        self.assertEqual(newest.recovery_behaviors, ["a"])
        chosen.publish(MoveBaseGoal(controller="d", recovery_behaviors=["b"]))
        bridge.wait_for("from now on planner (the server's first) and controller d")
        clicks.publish(stamped((2, 2, 3)))
        self.wait_for_goal(count=before + 2)
        newest = self.newest("move_base")
        self.assertEqual((newest.planner, newest.controller), ("", "d"))
        self.assertEqual(newest.recovery_behaviors, ["b"])
        before += 2

        def replace(handle):
            for old in self.server.goals["move_base"][:-1]:
                old.set_canceled(MoveBaseResult(outcome=11, message="newer"))
            handle.set_succeeded(MoveBaseResult(message="all is well"))

        self.server.answers["move_base"] = replace
        clicks.publish(stamped((4, 5, 6)))
        self.wait_for_goal(count=before + 1)
        bridge.wait_for("goal (4.00, 5.00, 6.00) in 'map': SUCCESS (0): all is well")
        bridge.wait_for("goal (1.00, 2.00, 3.00) in 'map': replaced by a newer one")
        self.server.answers["move_base"] = lambda handle: handle.set_aborted(
            MoveBaseResult(outcome=53, message="off the map")
        )
        clicks.publish(stamped((9, 9, 9)))
        bridge.wait_for("goal (9.00, 9.00, 9.00) in 'map': INVALID_GOAL (53): off the map")
        self.server.answers["move_base"] = never
        clicks.publish(stamped((7, 7, 7)))
        self.wait_for_goal(count=before + 3)
        bridge.process.send_signal(signal.SIGINT)
        self.assertEqual(bridge.end()[0], 0)
        self.assertEqual(len(self.server.canceled), 1)

    def test_the_bridge_drops_goals_without_a_server(self):
        bridge = Command(
            program("mesh_navigation", "goal_bridge"),
            "__name:=lonely",
            "_server:=nobody",
            "_recovery_behaviors:=wait",
            "/goal:=g",
        )
        self.addCleanup(bridge.kill)
        clicks = rospy.Publisher("/g", PoseStamped, queue_size=10, latch=True)
        clicks.publish(stamped((1, 2, 3)))
        text = "goal (1.00, 2.00, 3.00) in 'map' is dropped: there is no action server /nobody/move"
        bridge.wait_for(text)
        bridge.wait_for("~recovery_behaviors is 'wait', it has to be a list of names: all are used")


if __name__ == "__main__":
    rospy.init_node("clients_rostest")
    rostest.rosrun("mesh_navigation", "clients", ClientsTest)
