#!/usr/bin/python3
"""All actions and services while there is no map, not yet or not at all."""

import tempfile
import unittest
from pathlib import Path as FilePath

import rospy
import rostest
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import PointStamped
from mbf_msgs import msg
from mbf_msgs.srv import CheckPath, CheckPoint, CheckPose
from nav_msgs.msg import Path
from navigation_process import ACTIONS, ActionTopics, NodeProcess, upright
from server_process import write_map
from std_srvs.srv import Empty, Trigger

from mesh_msgs import zoo
from mesh_msgs.diagnostics_ros import ERROR, WARN
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics

GOALS = {
    "get_path": {"target_pose": upright(4, 4), "start_pose": upright(2, 2), "use_start_pose": True},
    "exe_path": {"path": Path(poses=[upright(2, 2), upright(4, 4)])},
    "recovery": {"behavior": "wait"},
    "move_base": {"target_pose": upright(4, 4)},
}
RESULTS = {
    "get_path": msg.GetPathResult,
    "exe_path": msg.ExePathResult,
    "recovery": msg.RecoveryResult,
    "move_base": msg.MoveBaseResult,
}


class MapStatesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """All servers at once; each test ends its own. Maps wait for a file, but for one."""
        folder = FilePath(tempfile.mkdtemp())
        cls.ready = {name: folder / name for name in ("hasty", "canceled", "stopping")}
        mesh_file = write_map(zoo.grid())
        maps = {
            name: {
                "mesh_file": mesh_file,
                "layers": [{"name": "patient", "type": "odd/PatientLayer"}],
                "patient": {"file": str(ready), "lethal_vertex": 60},
            }
            for name, ready in cls.ready.items()
        }
        maps["lost"] = {"mesh_file": "/nowhere/garden.h5"}
        steps = {"name": "steps", "type": "mesh_layers/HeightDifLayer"}
        for name, required in (("typo", True), ("optional", False)):
            layers = [dict(steps, required=required)]
            layers += [{"name": "border", "type": "mesh_layers/BorderLayer"}]
            layers += [{"name": "fussy", "type": "odd/FussyLayer"}]
            maps[name] = {"mesh_file": mesh_file, "layers": layers}
        others = {"hasty": {"wait_for_map": False}}
        cls.diagnostics = HeardDiagnostics()
        cls.servers = {
            name: NodeProcess(name, "mbf_mesh_nav", mesh_map=mesh_map, **others.get(name, {}))
            for name, mesh_map in maps.items()
        }

    @classmethod
    def tearDownClass(cls):
        for server in cls.servers.values():
            server.kill()

    def started(self, name):
        """A server and its topics."""
        server = self.servers[name]
        topics = {action: ActionTopics(name, action, server) for action in ACTIONS}
        for part in topics.values():
            self.addCleanup(part.close)
        return server, topics

    def patient(self, name):
        """A server whose map is loaded once a file is there; the file, server and topics."""
        return (self.ready[name], *self.started(name))

    def check(self, topics, expected, *words):
        """All actions are aborted with these outcomes."""
        for action in ACTIONS:
            topics[action].send(f"no map for {action}", **GOALS[action])
        for action, outcome in expected.items():
            state, result = topics[action].answer(f"no map for {action}")
            self.assertEqual((state, result.outcome), (4, outcome), result.message)
            for word in words:
                self.assertIn(word, result.message)

    def check_services(self, name, word):
        """All services fail with the reason."""
        for service, kind, request in (
            ("check_point_cost", CheckPoint, {"point": PointStamped()}),
            ("check_pose_cost", CheckPose, {"pose": upright(2, 2)}),
            ("check_path_cost", CheckPath, {"path": Path(poses=[upright(2, 2)])}),
            ("clear_mesh", Empty, {}),
        ):
            proxy = rospy.ServiceProxy(f"/{name}/{service}", kind)
            with self.assertRaises(rospy.ServiceException) as caught:
                proxy(**request)
            self.assertIn(word, str(caught.exception))

    def test_a_layer_of_a_misspelled_type(self):
        server, topics = self.started("typo")
        expected = {
            "get_path": msg.GetPathResult.MAP_ERROR,
            "exe_path": msg.ExePathResult.MAP_ERROR,
            "move_base": msg.GetPathResult.MAP_ERROR,
        }
        self.check(topics, expected, "layer steps: there is no", "mesh_layers/HeightDifLayer")
        self.assertEqual(topics["recovery"].answer("no map for recovery")[1].outcome, 0)  # waits
        for service, kind in (("check_pose_cost", CheckPose), ("check_path_cost", CheckPath)):
            with self.assertRaisesRegex(rospy.ServiceException, "layer steps: there is no"):
                rospy.ServiceProxy(f"/typo/{service}", kind)()
        rospy.ServiceProxy("/typo/clear_mesh", Empty)()
        for part in ("map", "navigation"):
            told = self.diagnostics.expected(f"typo: {part}", ERROR, "layer steps: there is no")
        self.assertEqual([(v.key, v.value) for v in told.values], [("ready", "False")])

    def test_a_layer_that_fails_while_the_map_is_in_use(self):
        server, topics = self.started("optional")
        ask = topics["get_path"]
        self.assertEqual(ask.answer(ask.send("without steps", **GOALS["get_path"]))[0], 3)
        self.diagnostics.expected("optional: map", WARN, "steps: there is no")
        Client("optional/mesh_map/border", 60).update_configuration({"border_cost": 6.0})
        state, result = ask.answer(ask.send("failed", **GOALS["get_path"]))
        self.assertEqual((state, result.outcome), (4, result.MAP_ERROR), result.message)
        self.diagnostics.expected(
            "optional: map", ERROR, "layer fussy: RuntimeError: 6 is too much"
        )
        Client("optional/mesh_map/fussy", 60).update_configuration({"enabled": False})
        self.assertEqual(ask.answer(ask.send("not enabled", **GOALS["get_path"]))[0], 3)

    def test_goals_that_do_not_wait(self):
        ready, server, topics = self.patient("hasty")
        not_yet = msg.GetPathResult.NOT_INITIALIZED
        expected = {action: kind.NOT_INITIALIZED for action, kind in list(RESULTS.items())[:3]}
        self.check(topics, {**expected, "move_base": not_yet}, "still being loaded", "wait_for_map")
        self.check_services(server.name, "still being loaded")
        ready.touch()
        self.assertEqual(server.end()[0], 0)

    def test_goals_that_wait_can_be_canceled(self):
        ready, server, topics = self.patient("canceled")
        keys = {action: f"waiting {action}" for action in ACTIONS}
        for action, key in keys.items():
            topics[action].send(key, **GOALS[action])
        self.check_services(server.name, "still being loaded")
        self.assertFalse(any(part.results for part in topics.values()))
        for action, key in keys.items():
            topics[action].cancel(key)
            state, result = topics[action].answer(key)
            self.assertIn(state, (2, 8))
            self.assertEqual(result.outcome, RESULTS[action].CANCELED)
            self.assertIn("cancel", result.message)
        topics["get_path"].send("patient", **GOALS["get_path"])
        ready.touch()
        self.assertEqual(topics["get_path"].answer("patient")[0], 3)
        self.assertEqual(server.end()[0], 0)

    def test_a_server_that_stops_while_goals_wait(self):
        ready, server, topics = self.patient("stopping")
        for action in ACTIONS:
            topics[action].send(f"waiting {action}", **GOALS[action])
        reload = rospy.ServiceProxy(f"/{server.name}/reload_map", Trigger)
        reload.wait_for_service(30)
        self.assertEqual(server.end()[0], 0, server.output())
        for action in ACTIONS:
            state, result = topics[action].answer(f"waiting {action}")
            stopped = getattr(RESULTS[action], "STOPPED", msg.GetPathResult.STOPPED)
            self.assertEqual((state, result.outcome), (4, stopped), result.message)
        self.assertNotIn("Traceback", server.output())

    def test_a_map_that_cannot_be_loaded(self):
        server, topics = self.started("lost")
        wait_until(lambda: "no map, goals will fail" in server.output(), "the end of loading")
        expected = {
            "get_path": msg.GetPathResult.MAP_ERROR,
            "exe_path": msg.ExePathResult.MAP_ERROR,
            "recovery": msg.RecoveryResult.NOT_INITIALIZED,
            "move_base": msg.GetPathResult.MAP_ERROR,
        }
        self.check(topics, expected, "there is no map", "/nowhere/garden.h5")
        self.check_services(server.name, "/nowhere/garden.h5")
        self.assertEqual(server.end()[0], 0)


if __name__ == "__main__":
    rospy.init_node("map_states_test")
    rostest.rosrun("mesh_navigation", "map_states", MapStatesTest)
