#!/usr/bin/python3
"""The real server drives the simulated robot, for every kind of client."""

import collections
import contextlib
import json
import math
import os
import signal
import subprocess
import threading
import time
import unittest

import numpy as np
import rosgraph
import rospy
import rostest
from geometry_msgs.msg import PoseStamped, Twist
from mesh_navigation import MeshNavigator
from mesh_navigation.base.messages import pose_from_message
from mesh_navigation.client.goal_poses import goal_pose
from navigation_machine import NavigationMachine
from server_process import ServerProcess, pid_of, program, write_map

from mesh_msgs import zoo
from mesh_msgs.testing import wait_until

GRID = zoo.grid()  # 10 m x 10 m, at the height 0
DISTANCE, ANGLE = 0.1, 0.2
SLACK = 0.02  # m, rad: what the robot moves until it has stopped
STANDS = 25  # poses, of 0.5 s


class DrivingTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        wait_until(rospy.get_time, "the simulated time")  # or timeouts begin at 0
        # The configuration that users of release 1.x have, with stricter tolerances.
        cls.server = ServerProcess(
            "move_base_flex",
            "mbf_mesh_nav",
            mesh_map={"mesh_file": write_map(GRID), "global_frame": "map"},
            planners=[
                {"name": "wave_front_planner", "type": "wave_front_planner/WaveFrontPlanner"}
            ],
            controllers=[{"name": "mesh_controller", "type": "mesh_controller/MeshController"}],
            mesh_controller={"ang_vel_factor": 7.0, "lin_vel_factor": 1.0},
            planner_max_retries=2,
            robot_frame="base_footprint",
            dist_tolerance=DISTANCE,
            angle_tolerance=ANGLE,
            controller_patience=2.0,
            controller_max_retries=4,
        )
        cls.navigator = MeshNavigator()
        cls.pose, cls.commands = collections.deque(maxlen=STANDS), []
        rospy.Subscriber("/surface_robot/pose", PoseStamped, cls.note_pose)
        rospy.Subscriber("/cmd_vel", Twist, cls.commands.append)
        cls.clicks = rospy.Publisher("/goal", PoseStamped, queue_size=10)
        cls.navigator.wait_until_ready(timeout=60)
        wait_until(lambda: cls.pose, "the robot")

    @classmethod
    def tearDownClass(cls):
        try:
            status = cls.server.stop()
        finally:
            cls.server.kill()
        assert status == 0, status

    @classmethod
    def note_pose(cls, message):
        cls.pose.append(pose_from_message(message.pose))

    def assert_at(self, x, y, yaw):
        """The robot itself, not what the server thinks, stands there."""
        wait_until(self.stands, "the robot's rest")
        pose = self.pose[-1]
        self.assertLess(np.linalg.norm(pose.position - [x, y, 0.0]), DISTANCE + SLACK)
        turn = math.atan2(pose.heading[1], pose.heading[0]) - yaw
        self.assertLess(abs(math.remainder(turn, 2 * math.pi)), ANGLE + SLACK)

    def stands(self):
        """Whether what has come of the robot is of one place: on a busy machine it comes late."""
        poses = list(self.pose)
        positions = np.array([each.position for each in poses])
        headings = np.array([each.heading for each in poses])
        moved = max(np.ptp(positions, axis=0).max(), np.ptp(headings, axis=0).max())
        return len(poses) == STANDS and moved < 1e-6

    def assert_stopped(self):
        wait_until(lambda: self.commands and is_stop(self.commands[-1]), "a zero velocity")

    def wait_for_motion(self):
        """Until a command that comes from now on moves the robot ahead."""
        begin = len(self.commands)
        wait_until(
            lambda: any(each.linear.x > 0.1 for each in self.commands[begin:]), "the robot's motion"
        )

    def test_time_waits_for_processes_that_stand_still(self):
        """And the drive goes on as if nothing had been; a guard is replaced meanwhile, and the next
        one says how far time may go on."""
        guard = "/move_base_flex_velocity_guard"
        pids = {node: pid_of(node) for node in ("/move_base_flex", "/surface_robot", guard)}
        with self.drive_away():
            for node, pid in pids.items():
                self.wait_for_motion()
                with stopped(pid):
                    time.sleep(0.3)  # what was on its way is here
                    begin = rospy.get_time()
                    time.sleep(0.4)  # no guard is replaced so soon
                    passed = rospy.get_time() - begin
                    time.sleep(1.3)
                self.assertLess(passed, 1.0, node)
        wait_until(lambda: pid_of(guard) not in (None, pids[guard]), "the next guard")

    def test_nobody_waits_for_roscore(self):
        master = rosgraph.Master("/driving_rostest").getPid()
        with self.drive_away():
            self.wait_for_motion()
            with stopped(master):
                time.sleep(2.0)

    @contextlib.contextmanager
    def drive_away(self):
        """A drive that gets there, whatever happens meanwhile."""
        away = 8.5 if self.pose[-1].position[0] < 5.0 else 1.5
        results = []

        def drive():
            results.append(self.navigator.go_to(away, away, 0.0, 0.0))

        thread = threading.Thread(target=drive, daemon=True)
        thread.start()
        yield
        thread.join(60)
        self.assertEqual(results[0].name, "SUCCESS", results[0])
        self.assert_at(away, away, 0.0)

    def test_a_state_machine(self):
        machine = NavigationMachine()
        thread = threading.Thread(target=machine.run, args=(2,), daemon=True)
        thread.start()
        wait_until(self.clicks.get_num_connections, "the machine")
        away = np.linalg.norm(self.pose[-1].position - [6.0, 3.0, 0.0])
        self.clicks.publish(goal_pose(6.0, 3.0, 0.0, 1.5))
        wait_until(lambda: len(machine.history) >= 3, "the first goal's end")
        expected = [("WAIT_FOR_GOAL", "received_goal"), ("PLANNING", "succeeded")]
        self.assertEqual(machine.history, [*expected, ("CONTROL", "succeeded")], machine.data)
        self.assert_at(6.0, 3.0, 1.5)
        data = machine.data
        self.assertLessEqual(data["dist_to_goal"], DISTANCE + 1e-6)
        self.assertLessEqual(data["angle_to_goal"], ANGLE + 1e-6)
        self.assertEqual(data["final_pose"].header.frame_id, "map")
        self.assertGreater(len(data["path"].poses), 2)
        self.assertAlmostEqual(data["cost"], away, delta=0.01 * away)
        self.assertTrue(data["message"])
        self.assert_stopped()
        self.clicks.publish(goal_pose(60.0, 3.0, 0.0))  # off the map
        thread.join(60)
        self.assertEqual(machine.history[3:], [expected[0], ("PLANNING", "aborted")])
        self.assertIn("60.00", machine.data["message"])

    def test_the_navigator(self):
        feedback = []
        result = self.navigator.go_to(3.0, 7.0, 0.0, yaw=-2.0, on_feedback=feedback.append)
        self.assertTrue(result.succeeded, result)
        self.assert_at(3.0, 7.0, -2.0)
        self.assertGreater(len(feedback), 20)
        self.assertGreater(max(each.last_cmd_vel.twist.linear.x for each in feedback), 0.5)
        # In a cycle for which TF is late, as on a busy machine, there is no pose.
        frames = {each.current_pose.header.frame_id for each in feedback}
        self.assertEqual(frames - {""}, {"map"})
        self.assert_stopped()

    def test_the_navigator_step_by_step(self):
        plan = self.navigator.get_path(7.0, 7.5, 0.0, yaw=0.5)
        self.assertTrue(plan.succeeded, plan)
        result = self.navigator.follow_path(plan.details.path)
        self.assertTrue(result.succeeded, result)
        self.assert_at(7.0, 7.5, 0.5)
        result = self.navigator.recover("back_up")
        self.assertTrue(result.succeeded, result)
        distance = np.linalg.norm(self.pose[-1].position[:2] - [7.0, 7.5])
        self.assertTrue(0.3 < distance < 0.8, distance)

    def test_a_cancel_stops_the_robot(self):
        results = []
        x = 8.5 if self.pose[-1].position[0] < 5.0 else 1.5
        thread = threading.Thread(
            target=lambda: results.append(self.navigator.go_to(x, 5.0, 0.0, 0.0)), daemon=True
        )
        thread.start()
        self.wait_for_motion()
        self.navigator.cancel()
        thread.join(60)
        self.assertEqual(results[0].name, "CANCELED")
        self.assert_stopped()

    def test_the_command_keeps_the_heading_of_arrival(self):
        start = self.pose[-1].position
        goal = np.array([2.0, 2.0, 0.0] if start[0] > 5.0 else [8.0, 8.0, 0.0])
        words = [str(value) for value in goal]
        done = subprocess.run(
            ["rosrun", "mesh_navigation", "go_to", *words, "--json"],
            capture_output=True,
            text=True,
            timeout=90,
        )
        # what is said where connections take longer than a second
        said = [
            one for one in done.stderr.splitlines() if "waiting for the action server" not in one
        ]
        self.assertEqual((done.returncode, said), (0, []), done.stdout)
        self.assertEqual(json.loads(done.stdout)["outcome_name"], "SUCCESS")
        away = goal - start
        self.assert_at(*goal[:2], math.atan2(away[1], away[0]))

    def test_a_click_drives_the_robot(self):
        bridge = subprocess.Popen(
            [program("mesh_navigation", "goal_bridge"), "/goal:=/click"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        self.addCleanup(bridge.kill)
        clicks = rospy.Publisher("/click", PoseStamped, queue_size=10)
        wait_until(clicks.get_num_connections, "the bridge")

        def moved():
            clicks.publish(goal_pose(5.0, 5.0, 0.0, 1.0))
            rospy.rostime.wallsleep(0.2)
            return any(each.linear.x > 0.1 for each in self.commands[before:])

        before = len(self.commands)
        wait_until(moved, "the robot's start")
        clicks.publish(goal_pose(4.0, 6.0, 0.0, 1.0))  # replaces the one before

        def arrived():
            away = np.linalg.norm(self.pose[-1].position[:2] - [4.0, 6.0])
            return away < DISTANCE + SLACK and is_stop(self.commands[-1])

        wait_until(arrived, "the second goal")
        bridge.terminate()
        bridge.communicate(timeout=30)
        self.assertEqual(bridge.returncode, 0)
        self.assert_at(4.0, 6.0, 1.0)


@contextlib.contextmanager
def stopped(pid):
    """A process that does not run, as on a computer that has other things to do."""
    os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        with contextlib.suppress(ProcessLookupError):  # somebody has ended it
            os.kill(pid, signal.SIGCONT)


def is_stop(command):
    return (command.linear.x, command.linear.y, command.angular.z) == (0.0, 0.0, 0.0)


if __name__ == "__main__":
    rospy.init_node("driving_rostest")
    rostest.rosrun("mesh_navigation", "driving", DrivingTest)
