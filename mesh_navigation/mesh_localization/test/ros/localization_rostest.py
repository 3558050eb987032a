#!/usr/bin/python3
"""The node mesh_localization beside a simulated robot, as its users meet it."""

import math
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client
from localization_machine import Machine
from mesh_map.registration.rigid import motion
from mesh_msgs.diagnostics_ros import OK as DIAGNOSTIC_OK
from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger

from mesh_localization.node.messages import cloud_message, transform_message

LOST, UNCERTAIN, OK = 0, 1, 2
NAME = "mesh_localization: localization"


class LocalizationTest(unittest.TestCase):
    def setUp(self):
        world = outdoor_world(40_000, size=30.0)
        self.machine = Machine(world, world.places["start"])
        self.addCleanup(self.machine.stop)
        self.diagnostics = HeardDiagnostics()

    def test_a_robot_is_followed_kidnapped_and_found_again(self):
        self.is_told_where_it_is()
        self.is_followed()
        self.is_kidnapped_and_found()
        self.hears_no_scans()
        self.gets_another_map()
        self.hears_another_localization()
        self.assertEqual(self.machine.stop(), [0, 0])

    def is_told_where_it_is(self):
        machine = self.machine
        machine.wait_for_state(LOST, "there is no map on /map/mesh yet")
        self.is_not_found("relocalize", "the robot cannot be looked for: there is no map on")
        machine.publish_map()
        machine.wait_for_state(LOST, "it has not been told where it is")
        self.is_not_found("relocalize_nearby", "nothing is known of where it is")
        self.assertFalse(machine.corrections)
        off = motion(np.array([0.3, -0.2, 0.0, 0.0, 0.0, math.radians(5)]))
        machine.say_pose(machine.place() @ off)
        machine.wait_for_state(OK)
        self.diagnostics.expected(NAME, DIAGNOSTIC_OK, "the robot is localized")

    def is_followed(self):
        machine = self.machine
        states, poses = len(machine.states), len(machine.poses)
        begin = machine.place()
        machine.drive(3.0, 0.8, 0.5)
        machine.drive(3.0, 0.8, -0.6)
        self.assertGreater(np.linalg.norm((machine.place() - begin)[:3, 3]), 1.0)
        wait_until(lambda: len(machine.poses) >= poses + 40, "poses")
        distances, angles = machine.errors(poses)
        self.assertGreater(len(distances), 30)
        self.assertLess(distances.max(), 0.05)
        self.assertLess(angles.max(), math.radians(1.5))
        self.assertEqual({one.state for one in machine.states[states:]}, {OK})

    def is_kidnapped_and_found(self):
        """Carried far away it is lost, and found by a search, or told where it is."""
        machine = self.machine
        self.is_carried_away("goal")
        self.is_not_found("relocalize_nearby", "")
        answer = rospy.ServiceProxy("/mesh_localization/relocalize", Trigger)()
        self.assertTrue(answer.success, answer.message)
        self.is_localized_again()
        self.is_carried_away("start")
        machine.say_pose(machine.place())
        self.is_localized_again()

    def is_not_found(self, service, words):
        rospy.wait_for_service("/mesh_localization/" + service)
        answer = rospy.ServiceProxy("/mesh_localization/" + service, Trigger)()
        self.assertFalse(answer.success, answer.message)
        self.assertIn(words, answer.message)

    def is_carried_away(self, place):
        machine, states = self.machine, len(self.machine.states)
        there = np.eye(4)
        there[:3, 3] = machine.mesh.places[place]
        taken = rospy.get_time()
        machine.say_pose(there, "/kidnapper")
        lost = machine.wait_for_state(LOST, since=states)
        self.assertLess(lost.header.stamp.to_sec() - taken, 2.6)

    def is_localized_again(self):
        machine = self.machine
        machine.wait_for_state(OK, since=len(machine.states) - 1)
        poses = len(machine.poses)
        wait_until(lambda: machine.errors(poses).size, "a pose")
        self.assertLess(machine.errors(poses)[0].max(), 0.05)

    def hears_no_scans(self):
        states = len(self.machine.states)
        client = Client("/surface_robot", timeout=30)
        client.update_configuration({"scan_rate": 0.0})
        self.machine.wait_for_state(UNCERTAIN, "no scan was believed for", states)
        self.machine.wait_for_state(LOST, "no scan was believed for", states)
        self.machine.wait_for_state(LOST, since=len(self.machine.states) + 1)
        corrections = len(self.machine.corrections)
        self.hears_odd_clouds()
        self.assertEqual(len(self.machine.corrections), corrections)
        states = len(self.machine.states)
        client.update_configuration({"scan_rate": 10.0})
        self.machine.wait_for_state(OK, since=states)

    def gets_another_map(self):
        machine = self.machine
        states, poses = len(machine.states), len(machine.poses)
        machine.publish_map(lifted=0.1)
        machine.wait_for_state(UNCERTAIN, since=states)
        machine.wait_for_state(OK, since=states)
        wait_until(lambda: machine.errors(poses).size, "a pose")
        self.assertLess(machine.errors(poses)[0].max(), 0.05)

    def hears_odd_clouds(self):
        publisher = rospy.Publisher("/cloud", PointCloud2, queue_size=10)
        wait_until(publisher.get_num_connections, "the node")
        nothing = np.full((10, 3), np.nan)
        for words, frame, seconds, points in (
            ("none of its 10 points is finite", "laser", 0.0, nothing),
            ("it has no point", "laser", 0.0, nothing[:0]),
            ("no transform from 'moon'", "moon", 0.0, np.diag([1.0, 2.0, 3.0])),
            ("it has no frame_id", "", 0.0, np.diag([1.0, 2.0, 3.0])),
            ("s old by its stamp", "laser", -60.0, np.diag([1.0, 2.0, 3.0])),
            ("s ahead of time", "laser", 9.0, np.diag([1.0, 2.0, 3.0])),
        ):
            stamp = rospy.Time.now() + rospy.Duration.from_sec(seconds)
            states = len(self.machine.states)
            publisher.publish(cloud_message(points, {}, frame, stamp))
            self.machine.wait_for_state(LOST, words, states)

    def hears_another_localization(self):
        broadcaster, heard = tf2_ros.TransformBroadcaster(), []
        rospy.Subscriber("/diagnostics", DiagnosticArray, heard.append)

        def is_told():
            moment = transform_message("map", "odom", np.eye(4), rospy.Time.now())
            broadcaster.sendTransform(moment)
            rospy.rostime.wallsleep(0.1)
            parts = [one for message in list(heard) for one in message.status if one.name == NAME]
            return any("publishes where frame odom is, too" in one.message for one in parts)

        wait_until(is_told, "a warning")


if __name__ == "__main__":
    rospy.init_node("localization_test")
    rostest.rosrun("mesh_localization", "localization", LocalizationTest)
