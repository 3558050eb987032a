#!/usr/bin/python3
"""The server as users start it, from outside: names, types, headers, command line tools."""

import io
import os
import socket
import subprocess
import unittest
import xmlrpc.client
from concurrent import futures

import rosgraph
import rosgraph.network
import rospy
import rosservice
import rostest
import yaml
from actionlib_msgs.msg import GoalID, GoalStatusArray
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import PoseStamped, Twist
from mbf_msgs import msg
from nav_msgs.msg import Path
from navigation_process import ACTIONS, ActionTopics, NodeProcess
from rospy.impl import tcpros_base
from server_process import TIMEOUT, write_map
from std_msgs.msg import Float32
from std_srvs.srv import Empty, Trigger
from test_mbf_interface import MESSAGE_MD5, SERVICE_MD5

from mesh_msgs import zoo
from mesh_msgs.testing import wait_until

NAME = "/move_base_flex"
DEFAULTS = {
    "planner_frequency": 0.0,
    "planner_patience": 5.0,
    "planner_max_retries": -1,
    "controller_frequency": 20.0,
    "controller_patience": 5.0,
    "controller_max_retries": -1,
    "recovery_enabled": True,
    "recovery_patience": 15.0,
    "oscillation_timeout": 0.0,
    "oscillation_distance": 0.5,
    "oscillation_angle": 3.14,
    "restore_defaults": False,
}
LIMITS = {
    "planner_frequency": (0, 100),
    "planner_patience": (0, 100),
    "planner_max_retries": (-1, 1000),
    "controller_frequency": (0, 100),
    "controller_patience": (0, 100),
    "controller_max_retries": (-1, 1000),
    "recovery_patience": (0, 100),
    "oscillation_timeout": (0, 60),
    "oscillation_distance": (0, 10),
    "oscillation_angle": (0, 6.28),
}
LAYERS = [{"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}]
PLANNERS = ["dijkstra_mesh_planner", "wave_front_planner", "mmp_planner"]
RECONFIGURED = ["", "mesh_map", "mesh_controller", "clear_layers", "wait", "back_up", *PLANNERS]


def header_of(topic, md5="*", kind="*"):
    """What a publisher of a topic says to a subscriber that connects, or why it does not."""
    master = rosgraph.Master(rospy.get_name())
    publishers = dict(master.getSystemState()[0])[topic]
    node = xmlrpc.client.ServerProxy(master.lookupNode(publishers[0]))
    code, text, (_, host, port) = node.requestTopic("/nobody", topic, [["TCPROS"]])
    assert code == 1, text
    with socket.create_connection((host, port), 30) as connection:
        fields = {"callerid": "/nobody", "topic": topic, "md5sum": md5, "type": kind}
        rosgraph.network.write_ros_handshake_header(connection, fields)
        return rosgraph.network.read_ros_handshake_header(connection, io.BytesIO(), 65536)


def command(*words, **environment):
    """Run a command line tool of ROS; returns what it prints."""
    done = subprocess.run(
        words,
        env={**os.environ, **environment},
        timeout=60,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


def all_of(*calls):
    """What these functions return, called at once; each call is (function, *arguments)."""
    with futures.ThreadPoolExecutor(len(calls)) as pool:
        return [done.result() for done in [pool.submit(*call) for call in calls]]


def dynparam(*words):
    """Run the tool of dynamic_reconfigure, by the interpreter that has its modules."""
    return command("/usr/bin/python3", "/usr/lib/dynamic_reconfigure/dynparam", *words)


class InterfaceTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.headers = []
        server = tcpros_base._tcpros_server
        connect = server.topic_connection_handler

        def note(connection, address, header):
            cls.headers.append(dict(header))
            return connect(connection, address, header)

        server.topic_connection_handler = note
        cls.server = NodeProcess(
            "move_base_flex",
            "mbf_mesh_nav",
            "mbf_mesh_nav",
            mesh_map={"mesh_file": write_map(zoo.grid()), "layers": LAYERS},
            tf_timeout=0.3,
        )
        cls.topics = {
            action: ActionTopics("move_base_flex", action, cls.server) for action in ACTIONS
        }
        rospy.wait_for_message(f"{NAME}/mesh_map/mesh", rospy.AnyMsg, TIMEOUT.to_sec())
        wait_until(lambda: "ready, map" in cls.server.output(), "the map")

    @classmethod
    def tearDownClass(cls):
        try:
            status, _ = cls.server.end()
        finally:
            cls.server.kill()
        assert status == 0, cls.server.output()

    def test_one_line_says_what_is_waited_for(self):
        lines = self.server.output().splitlines()
        begin = [line for line in lines if "waiting for the map" in line]
        ready = [line for line in lines if "ready, map of" in line]
        self.assertEqual((len(begin), len(ready)), (1, 1))
        for word in (*PLANNERS, "mesh_controller", "clear_layers, wait, back_up", *ACTIONS):
            self.assertIn(word, begin[0])
        self.assertIn("from 'base_link' to 'map'", ready[0])
        start = self.server.output().split("ready, map of")[0].splitlines()
        start = [line for line in start if "is in faces with edges longer" not in line]
        for word in ("WARN", "ERROR", "Traceback"):
            self.assertEqual([line for line in start if word in line], [])

    def test_what_the_actions_publish(self):
        for action, kind in ACTIONS.items():
            for topic, name in (("result", f"{kind}ActionResult"), ("feedback", "ActionFeedback")):
                name = name if topic == "result" else f"{kind}{name}"
                header = header_of(f"{NAME}/{action}/{topic}")
                self.assertEqual(header["type"], f"mbf_msgs/{name}")
                self.assertEqual(header["md5sum"], MESSAGE_MD5[name])
            header = header_of(f"{NAME}/{action}/status")
            self.assertEqual(header["md5sum"], GoalStatusArray._md5sum)
            self.assertEqual(header["latching"], "1")

    def test_what_the_actions_ask_clients_for(self):
        """The header that the server sends to who publishes goals, as rostopic pub does."""
        for action, kind in ACTIONS.items():
            for topic, md5, name in (
                ("goal", MESSAGE_MD5[f"{kind}ActionGoal"], f"mbf_msgs/{kind}ActionGoal"),
                ("cancel", GoalID._md5sum, GoalID._type),
            ):
                found = [
                    (header["md5sum"], header["type"])
                    for header in self.headers
                    if header["topic"] == f"{NAME}/{action}/{topic}" and header["callerid"] == NAME
                ]
                self.assertEqual(set(found), {(md5, name)})

    def test_a_client_of_another_version_is_refused(self):
        topic = f"{NAME}/get_path/result"
        md5 = "d67aca1f3dee54d1f090431dcebfe886"  # of Move Base Flex's master
        self.assertIn("error", header_of(topic, md5, "mbf_msgs/GetPathActionResult"))

    def test_other_topics(self):
        for topic, kind, latched in (
            ("/cmd_vel", Twist, False),
            (f"{NAME}/current_goal", PoseStamped, False),
            (f"{NAME}/mesh_controller/current_angle", Float32, False),
            *((f"{NAME}/{name}/path", Path, True) for name in PLANNERS),
        ):
            header = header_of(topic)
            self.assertEqual((header["type"], header["md5sum"]), (kind._type, kind._md5sum))
            self.assertEqual(header.get("latching", "0"), str(int(latched)), topic)
        subscribed = dict(rosgraph.Master(rospy.get_name()).getSystemState()[1])
        for topic in ("/tf", "/tf_static", "/odom"):
            self.assertIn(NAME, subscribed[topic])

    def test_services(self):
        for service, md5 in (
            ("check_pose_cost", SERVICE_MD5["CheckPose"][0]),
            ("check_path_cost", SERVICE_MD5["CheckPath"][0]),
            ("check_point_cost", SERVICE_MD5["CheckPoint"][0]),
            ("clear_mesh", Empty._md5sum),
            ("reload_map", Trigger._md5sum),
        ):
            name = f"{NAME}/{service}"
            uri = rosservice.get_service_uri(name)
            self.assertIsNotNone(uri, name)
            self.assertEqual(rosservice.get_service_headers(name, uri)["md5sum"], md5, name)

    def test_rosservice_call(self):
        command("rosservice", "call", f"{NAME}/clear_mesh")
        at = "{point: {header: {frame_id: map}, point: {x: 3, y: 3}}, costmap: 2}"
        pose = "{header: {frame_id: map}, pose: {position: {x: 3, y: 3}, orientation: {w: 1}}}"
        asked = {
            "check_point_cost": at,
            "check_pose_cost": f"{{pose: {pose}, costmap: 2}}",
            "check_path_cost": f"{{path: {{poses: [{pose}]}}}}",
        }
        calls = [
            (command, "rosservice", "call", f"{NAME}/{name}", text) for name, text in asked.items()
        ]
        first, *others = map(yaml.safe_load, all_of(*calls))
        self.assertEqual(first, {"state": 0, "cost": 0})
        self.assertEqual([other["state"] for other in others], [0, 0])

    def test_parameters(self):
        values = rospy.get_param(NAME)
        for name, value in DEFAULTS.items():
            self.assertEqual(values[name], value, name)
        self.assertEqual(values["mesh_controller"]["max_lin_velocity"], 1.0)

    def test_dynparam(self):
        """The command line tool of dynamic_reconfigure, at every place of the sheet."""
        listed, given = all_of((dynparam, "list"), (dynparam, "get", NAME))
        for name in RECONFIGURED:
            self.assertIn(f"{NAME}/{name}".rstrip("/"), listed.split())
        given = yaml.safe_load(given)
        self.assertEqual({name: given[name] for name in DEFAULTS}, DEFAULTS)
        controller = f"{NAME}/mesh_controller"
        all_of(
            (dynparam, "set", NAME, "planner_patience", "7.5"),
            (dynparam, "set", NAME, "controller_max_retries", "3"),
            (dynparam, "set", NAME, "planner_frequency", "-1.0"),
            (dynparam, "set", controller, "max_lin_velocity", "0.7"),
        )
        found = rospy.get_param(NAME)
        names = "planner_patience", "controller_max_retries", "planner_frequency"
        self.assertEqual([found[name] for name in names], [7.5, 3, 0.0])
        _, given = all_of(
            (dynparam, "set", NAME, "restore_defaults", "true"), (dynparam, "get", controller)
        )
        self.assertEqual(yaml.safe_load(given)["max_lin_velocity"], 0.7)
        given, _ = all_of(
            (dynparam, "get", NAME), (dynparam, "set", controller, "max_lin_velocity", "1.0")
        )
        given = yaml.safe_load(given)
        self.assertEqual({name: given[name] for name in DEFAULTS}, DEFAULTS)

    def test_limits(self):
        client = Client(NAME, timeout=30)
        for end in (0, 1):
            beyond = {name: limits[end] + 2 * end - 1 for name, limits in LIMITS.items()}
            given = client.update_configuration(beyond)
            self.assertEqual(
                {name: given[name] for name in LIMITS},
                {name: limits[end] for name, limits in LIMITS.items()},
            )
        # get_configuration() may still have what was published before.
        given = client.update_configuration({"restore_defaults": True})
        self.assertEqual({name: given[name] for name in DEFAULTS}, DEFAULTS)
        client.close()

    def test_rostopic_pub(self):
        """One goal of each action, from the command line; all at once, each takes 3 s."""
        goals = {
            "get_path": "{target_pose: {header: {frame_id: nowhere}}, use_start_pose: true}",
            "exe_path": "{controller: mesh_controller}",
            "recovery": "{behavior: clear_layers}",
            "move_base": "{target_pose: {header: {frame_id: map}, pose: {orientation: {w: 1}}}}",
        }
        expected = {
            "get_path": (4, msg.GetPathResult.TF_ERROR),
            "exe_path": (4, msg.ExePathResult.INVALID_PATH),
            "recovery": (4, msg.RecoveryResult.FAILURE),  # the map has no layer that forgets
            "move_base": (4, msg.MoveBaseResult.TF_ERROR),  # nobody knows where the robot is
        }
        before = {action: set(self.topics[action].results) for action in ACTIONS}
        publishers = [
            subprocess.Popen(
                ["rostopic", "pub", "-1", f"{NAME}/{action}/goal"]
                + [f"mbf_msgs/{ACTIONS[action]}ActionGoal", f"{{goal: {goal}}}"],
                stdout=subprocess.DEVNULL,
            )
            for action, goal in goals.items()
        ]
        for action, topics in self.topics.items():
            wait_until(lambda: set(topics.results) - before[action], "a result")
            (key,) = set(topics.results) - before[action]
            state, result = topics.answer(key)
            self.assertEqual((state, result.outcome), expected[action], result.message)
            self.assertTrue(result.message)
        self.assertEqual([publisher.wait(60) for publisher in publishers], [0] * 4)

    def test_unknown_plugins(self):
        for action, field, outcome in (
            ("get_path", "planner", msg.GetPathResult.INVALID_PLUGIN),
            ("exe_path", "controller", msg.ExePathResult.INVALID_PLUGIN),
            ("recovery", "behavior", msg.RecoveryResult.INVALID_PLUGIN),
            ("move_base", "planner", msg.GetPathResult.INVALID_PLUGIN),
            ("move_base", "controller", msg.ExePathResult.INVALID_PLUGIN),
        ):
            key = f"unknown {field} of {action}"
            self.topics[action].send(key, **{field: "nobody"})
            state, result = self.topics[action].answer(key)
            self.assertEqual((state, result.outcome), (5, outcome))
            self.assertIn("'nobody'; known: ", result.message)


if __name__ == "__main__":
    rospy.init_node("interface_test")
    rostest.rosrun("mesh_navigation", "interface", InterfaceTest)
