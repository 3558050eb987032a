#!/usr/bin/python3
"""The action get_path, asked by a real actionlib client."""

import random
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np
import rospy
import rostest
import tf2_ros
from actionlib_msgs.msg import GoalID, GoalStatusArray
from geometry_msgs.msg import PoseStamped, TransformStamped
from mbf_msgs.msg import GetPathActionGoal, GetPathActionResult, GetPathResult
from nav_msgs.msg import Path as PathMessage
from server_process import (
    STATES,
    ServerProcess,
    Topics,
    answer,
    positions,
    published_topics,
    stamped,
    wait_until,
    write_map,
)
from visualization_msgs.msg import Marker

from mesh_msgs import zoo
from mesh_msgs.arrays import MeshVertexCostsStamped
from mesh_msgs.msg import LayerInfoArray
from mesh_msgs.testing_ros import connected

GRID = zoo.grid()
LETHAL = 60  # the vertex in the middle, at (5, 5)
START = (2.1, 2.1, 0.0)
GOAL = (8.1, 8.1, 0.0)
ODD = "Outcome Slow Deaf Throwing Nan Lame Unimportable".split()
PLANNERS = [{"name": name.lower(), "type": f"odd/{name}"} for name in ODD]
PLANNERS += [
    {"name": "dijkstra", "type": "dijkstra_mesh_planner/DijkstraMeshPlanner"},
    {"name": "mmp_planner", "type": "nobody/NoPlanner"},
]


def transform(child, x, y, z, half_turn=False):
    """A static transform from the map to a child frame."""
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = "map", child
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = x, y, z
    rotation.z, rotation.w = (1.0, 0.0) if half_turn else (0.0, 1.0)
    return message


def mesh_map_parameters(ready=None):
    """Parameters of a grid with a lethal vertex; ready once the file of that name exists."""
    ready = ready or write_map(GRID)
    return {
        "mesh_file": write_map(GRID),
        "layers": [{"name": "patient", "type": "odd/PatientLayer"}],
        "patient": {"file": str(ready), "lethal_vertex": LETHAL},
    }


def slow_goal(key):
    """A goal for the slow planner, as it is on the wire."""
    goal = GetPathActionGoal(goal_id=GoalID(id=key))
    goal.goal.planner, goal.goal.use_start_pose = "slow", True
    goal.goal.start_pose, goal.goal.target_pose = stamped(START), stamped(GOAL)
    return goal


class GetPathTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # As users start it: nothing but a map; its planners are the default ones.
        cls.plain = ServerProcess(
            "move_base_flex",
            "mbf_mesh_nav",
            wait=False,
            mesh_map=mesh_map_parameters(),
            tf_timeout=0.3,
        )
        cls.odd = ServerProcess(
            "odd_server",
            wait=False,
            planners=PLANNERS,
            mesh_map=mesh_map_parameters(),
            planner_patience=1.0,
            planner_max_retries=2,
            slow={"seconds": 1000.0},
            dijkstra={"cost_limit": 99, "publish_vector_field": True},
        )
        cls.late = ServerProcess("late_server", wait=False, mesh_map=mesh_map_parameters())
        for server in (cls.plain, cls.odd):
            server.wait_for_server()

    @classmethod
    def tearDownClass(cls):
        try:
            statuses = [server.stop() for server in (cls.plain, cls.odd)]
        finally:
            for server in (cls.plain, cls.odd, cls.late):
                server.kill()
        assert statuses == [0, 0], statuses

    def check(self, given, state, outcome, *words):
        found, result = given
        self.assertEqual((found, result.outcome), (state, outcome), result.message)
        for word in words:
            self.assertIn(word, result.message)
        if state != "SUCCEEDED":
            self.assertEqual(result.path.poses, [])
        return result

    def test_success(self):
        result = self.check(self.plain.ask(START, GOAL), "SUCCEEDED", 0, "path of ")
        self.assertEqual(result.path.header.frame_id, "map")
        self.assertGreater(result.path.header.stamp, rospy.Time())
        self.assertEqual({pose.header.frame_id for pose in result.path.poses}, {"map"})
        points = positions(result.path)
        np.testing.assert_allclose(points[[0, -1]], [START, GOAL], atol=1e-6)
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        self.assertAlmostEqual(result.cost, length, places=5)
        self.assertFalse((points == GRID.vertices[LETHAL]).all(axis=1).any())

    def test_topics(self):
        topics = published_topics()
        expected = {"get_path/status", "get_path/result", "current_goal", "mesh_map/vertex_costs"}
        expected |= {"dijkstra_mesh_planner/path", "wave_front_planner/path", "mmp_planner/path"}
        expected |= {"mesh_map/mesh", "parameter_updates", "mmp_planner/parameter_updates"}
        self.assertLessEqual({f"/move_base_flex/{name}" for name in expected}, topics)

    def test_vector_field(self):
        given = self.odd.ask(START, GOAL, planner="dijkstra", concurrency_slot=4)
        self.check(given, "SUCCEEDED", 0)
        shown = []  # that of a plan before may have been taken away meanwhile
        topic = "/odd_server/mesh_map/vector_field"
        subscriber = rospy.Subscriber(topic, Marker, shown.append, queue_size=100)
        wait_until(lambda: shown and shown[-1].action == Marker.ADD, "the vector field")
        subscriber.unregister()
        marker = shown[-1]
        self.assertEqual((marker.ns, marker.type), ("vector_field", Marker.LINE_LIST))
        self.assertEqual(len(marker.points), len(marker.colors))
        self.assertGreater(len(marker.points), 100)

    def test_markers_of_a_plan(self):
        markers = {}
        subscriber = rospy.Subscriber(
            "/move_base_flex/mesh_map/marker",
            Marker,
            lambda marker: markers.update({marker.ns: marker}),
            queue_size=100,
        )
        names = {"start_point", "start_face", "plan_start", "goal_point", "goal_face", "plan_goal"}
        self.check(self.plain.ask(START, GOAL), "SUCCEEDED", 0)

        def there():
            found = [marker for marker in markers.values() if marker.action == Marker.ADD]
            return len(found) == len(names)

        wait_until(there, "markers")
        self.assertEqual(set(markers), names)
        self.assertEqual({marker.header.frame_id for marker in markers.values()}, {"map"})
        subscriber.unregister()

    def test_what_a_plan_publishes(self):
        goals, paths, costs, infos = [], [], {}, {}
        subscribers = [
            rospy.Subscriber("/move_base_flex/current_goal", PoseStamped, goals.append),
            rospy.Subscriber(
                "/move_base_flex/dijkstra_mesh_planner/path", PathMessage, paths.append
            ),
            rospy.Subscriber(
                "/move_base_flex/mesh_map/vertex_costs",
                MeshVertexCostsStamped,
                lambda message: costs.update({message.type: message.mesh_vertex_costs.costs}),
                queue_size=4,
            ),
            rospy.Subscriber(
                "/move_base_flex/mesh_map/layer_info",
                LayerInfoArray,
                lambda message: infos.update({info.name: info for info in message.layers}),
            ),
        ]
        wait_until(lambda: connected(*subscribers), "connections")
        result = self.check(self.plain.ask(START, GOAL), "SUCCEEDED", 0)
        # Topics follow the answer; what is latched may be older.
        wait_until(lambda: any(path.poses == result.path.poses for path in paths), "the path")
        near_goal = (GRID.vertices == [8, 8, 0]).all(axis=1)

        def potential_is_there():
            return np.isclose(costs.get("Potential", 0 * near_goal)[near_goal], np.hypot(0.1, 0.1))

        wait_until(potential_is_there, "the potential")
        wait_until(lambda: {"patient", "Combined Costs"} <= set(costs), "costs")
        wait_until(lambda: goals, "the goal")
        wait_until(lambda: "Potential" in infos, "what the potential means")
        for subscriber in subscribers:
            subscriber.unregister()
        self.assertEqual(goals[-1].pose.position.x, GOAL[0])
        self.assertEqual(np.isinf(costs["Combined Costs"]).nonzero()[0].tolist(), [LETHAL])
        combined, potential = infos["Combined Costs"], infos["Potential"]
        self.assertEqual((combined.lethal, combined.cost_limit), (1, 1.0))
        self.assertEqual((combined.infinity, potential.infinity), ("lethal", "not reached"))
        self.assertTrue(np.isnan(potential.cost_limit))

    def test_unknown_planner_is_rejected(self):
        given = self.plain.ask(START, GOAL, planner="dijkstra_planner")
        self.check(given, "REJECTED", 59, "'dijkstra_planner'", "known: dijkstra_mesh_planner")

    def test_planners_that_cannot_be_used(self):
        given = self.odd.ask(START, GOAL, planner="mmp_planner")
        self.check(given, "REJECTED", 59, "known: outcome, slow, deaf")
        self.check(self.odd.ask(START, GOAL, planner="unimportable"), "REJECTED", 59)
        given = self.odd.ask(START, GOAL, planner="lame")
        self.check(given, "ABORTED", 58, "'lame' could not be initialized", "no legs")
        output = self.odd.output()
        for words in ("planner 'mmp_planner' is skipped", "planner 'unimportable' is skipped"):
            self.assertEqual(output.count(words), 1, output)
        self.assertIn("cost_limit is 99, outside of", output)

    def test_invalid_start_and_goal(self):
        high, blocked = (5, 5, 3), (5.1, 5, 0)
        self.check(self.plain.ask(high, GOAL), "ABORTED", 52, "start", "3.00 m from the map")
        self.check(self.plain.ask(START, high), "ABORTED", 53, "goal", "3.00 m from the map")
        words = "vertex 60", "lethal in layer patient"
        self.check(self.plain.ask(blocked, GOAL), "ABORTED", 52, *words)
        self.check(self.plain.ask(START, blocked), "ABORTED", 53, *words)
        given = self.plain.ask(START, blocked, tolerance=1.5)
        self.check(given, "SUCCEEDED", 0, "tolerance 1.50 m")

    def test_poses_that_are_none(self):
        without_rotation = stamped(GOAL)
        without_rotation.pose.orientation.w = 0.0
        self.check(self.plain.ask(START, without_rotation), "ABORTED", 53, "no rotation")
        self.check(self.plain.ask(without_rotation, GOAL), "ABORTED", 52, "no rotation")
        self.check(self.plain.ask(START, (np.nan, 0, 0)), "ABORTED", 53, "not finite")
        long = stamped(GOAL)
        long.pose.orientation.w = 5.0
        self.check(self.plain.ask(START, long), "SUCCEEDED", 0)

    def test_frames(self):
        given = self.plain.ask(START, stamped(GOAL, "nowhere"))
        self.check(given, "ABORTED", 57, "goal pose", "'nowhere' to 'map'", "0.3 s")
        given = self.plain.ask(stamped(START, ""), GOAL)
        self.check(given, "ABORTED", 57, "start pose has no frame_id")
        self.check(self.plain.ask(None, GOAL), "ABORTED", 57, "'base_link' to 'map'")
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        broadcaster.sendTransform(
            [transform("base_link", 1.1, 2.2, 0.1), transform("odom", 10.0, 10.0, 0.0, True)]
        )
        turned = stamped((1.9, 2.9, 0.0), "odom")
        wait_until(lambda: self.plain.ask(None, turned)[1].outcome != 57, "TF")
        result = self.check(self.plain.ask(None, turned), "SUCCEEDED", 0)
        ends = positions(result.path)[[0, -1]]
        np.testing.assert_allclose(ends, [[1.1, 2.2, 0], [8.1, 7.1, 0]], atol=1e-6)
        last = result.path.poses[-1].pose.orientation
        self.assertAlmostEqual(abs(last.z), 1.0)

    def test_outcomes_of_planners(self):
        for outcome in (50, 54, 61, 71, 99):
            given = self.odd.ask(START, (outcome, 0, 0), planner="outcome")
            self.check(given, "ABORTED", outcome, f"outcome {outcome}, as asked for")
        given = self.odd.ask(START, (7, 0, 0), planner="outcome")
        self.check(given, "SUCCEEDED", 7, "outcome 7")
        self.check(self.odd.ask(START, (3, 0, 0), planner="outcome"), "ABORTED", 56)
        self.check(self.odd.ask(START, (51, 0, 0), planner="outcome"), "PREEMPTED", 51)

    def test_planners_that_fail(self):
        given = self.odd.ask(START, GOAL, planner="throwing")
        self.check(given, "ABORTED", 60, "ZeroDivisionError: by zero")
        self.check(self.odd.ask(START, GOAL, planner="nan"), "ABORTED", 60, "2 of 2 poses")

    def test_patience(self):
        self.check(self.odd.ask(START, GOAL, planner="slow"), "ABORTED", 55, "patience of 1.00 s")
        given = self.odd.ask(START, GOAL, planner="deaf")
        self.check(given, "ABORTED", 55, "patience of 1.00 s", "did not stop within")

    def test_the_first_planner_is_the_default(self):
        self.check(self.odd.ask(START, (99, 0, 0)), "ABORTED", 99)

    def test_fifty_cancels_at_random_times(self):
        """On bare topics: actionlib's client loses a goal it cancels before the acknowledgement."""
        server = Topics("/odd_server/get_path")
        pauses = random.Random(0)
        for number in range(50):
            goal = slow_goal(f"cancel {number}")
            server.goal.publish(goal)
            time.sleep(pauses.choice([0.0, pauses.uniform(0, 0.03)]))
            server.cancel.publish(goal.goal_id)
            wait_until(lambda: goal.goal_id.id in server.results, "an answer")
            answered = server.results[goal.goal_id.id]
            self.assertIn(STATES[answered.status.status], ("PREEMPTED", "RECALLED"))
            self.assertEqual(answered.result.outcome, GetPathResult.CANCELED)
            self.assertIn("cancel", answered.result.message)

    def test_a_cancel_that_overtakes_its_goal(self):
        server = Topics("/odd_server/get_path")
        goal = slow_goal("overtaken")
        server.cancel.publish(goal.goal_id)
        wait_until(lambda: "overtaken" in server.seen, "the cancel")
        server.goal.publish(goal)
        wait_until(lambda: "overtaken" in server.results, "an answer")
        answered = server.results["overtaken"]
        self.assertEqual(STATES[answered.status.status], "RECALLED")
        self.assertEqual(answered.result.outcome, GetPathResult.CANCELED)
        self.assertIn("canceled before planning", answered.result.message)

    def test_results_reach_a_client_that_connects_late(self):
        """As actionlib's clients do: their wait_for_server() does not wait for the result topic."""
        topic = "/late_server/get_path"
        server = self.late.wait_for_server()
        publisher = rospy.Publisher(f"{topic}/goal", GetPathActionGoal, queue_size=1)
        server.client.stop()
        self.addCleanup(publisher.unregister)
        wait_until(publisher.get_num_connections, "the server")
        goal = slow_goal("late")
        goal.goal.planner = "unknown"
        ended = set()
        status = rospy.Subscriber(
            f"{topic}/status",
            GoalStatusArray,
            lambda message: ended.update(
                item.goal_id.id for item in message.status_list if item.status == 5
            ),
        )
        publisher.publish(goal)
        wait_until(lambda: "late" in ended, "the end of the goal")
        results = []
        late = rospy.Subscriber(f"{topic}/result", GetPathActionResult, results.append)
        wait_until(lambda: results, "the result")
        command = ["rostopic", "echo", "-n1", f"{topic}/result"]
        later = subprocess.run(command, check=True, timeout=60, stdout=subprocess.PIPE, text=True)
        self.assertIn('id: "late"', later.stdout)
        for subscriber in (status, late):
            subscriber.unregister()
        self.assertEqual([result.status.goal_id.id for result in results], ["late"])
        self.assertEqual(results[0].result.outcome, GetPathResult.INVALID_PLUGIN)

    def test_a_new_goal_takes_the_slot(self):
        old = self.odd.send(START, GOAL, planner="slow", concurrency_slot=1)
        wait_until(lambda: old.get_goal_status() == 1, "the goal's start")
        new = self.odd.send(START, GOAL, planner="dijkstra", concurrency_slot=1)
        self.check(answer(new), "SUCCEEDED", 0)
        self.check(answer(old), "PREEMPTED", 51, "a newer goal took slot 1")

    def test_two_slots_at_once(self):
        first = self.odd.send(START, GOAL, planner="slow", concurrency_slot=2)
        second = self.odd.ask(START, GOAL, planner="dijkstra", concurrency_slot=3)
        self.check(second, "SUCCEEDED", 0)
        # Its status comes on a topic of its own, and may be heard after the answer to the second.
        wait_until(lambda: first.get_goal_status() != 0, "the first goal's status")
        self.assertEqual(first.get_goal_status(), 1)
        first.cancel()
        self.check(answer(first), "PREEMPTED", 51, "a client canceled the goal")

    def test_a_storm_on_one_slot(self):
        handles = [self.odd.send(START, GOAL, planner="slow") for _ in range(40)]
        handles.append(self.odd.send(START, GOAL, planner="dijkstra"))
        self.check(answer(handles[-1]), "SUCCEEDED", 0)
        for handle in handles[:-1]:
            self.check(answer(handle), "PREEMPTED", 51)

    def test_rostopic_pub(self):
        topic = "/move_base_flex/get_path"
        server = Topics(topic)
        before = set(server.results)
        goal = (
            "{goal: {use_start_pose: true, start_pose: {header: {frame_id: map}, pose: {position: "
            "{x: 1, y: 1}, orientation: {w: 1}}}, target_pose: {header: {frame_id: map}, pose: "
            "{position: {x: 3, y: 1.5}, orientation: {w: 1}}}}}"
        )
        command = ["rostopic", "pub", "-1", f"{topic}/goal", "mbf_msgs/GetPathActionGoal", goal]
        publisher = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        self.addCleanup(publisher.wait, 60)
        self.addCleanup(publisher.terminate)  # it would latch for 3 s
        wait_until(lambda: set(server.results) - before, "a result")
        (found,) = set(server.results) - before
        result = server.results[found].result
        self.assertEqual(result.outcome, 0, result.message)
        last = result.path.poses[-1].pose.position
        self.assertEqual((last.x, last.y), (3.0, 1.5))


class MapLoadingTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """All servers at once; each test ends its own."""
        folder = Path(tempfile.mkdtemp())
        cls.files = {name: folder / name for name in ("early", "hasty", "stopping")}
        maps = {name: mesh_map_parameters(file) for name, file in cls.files.items()}
        maps["lost"] = {"mesh_file": "/nowhere/garden.h5"}
        maps["shapeless"] = {"mesh_file": write_map(GRID)}
        others = {
            "hasty": {"wait_for_map": False},
            "shapeless": {"footprint": "[[1, 2], [3, 4]]", "robot_radius": 0.1},
        }
        cls.servers = {
            name: ServerProcess(name, wait=False, mesh_map=mesh_map, **others.get(name, {}))
            for name, mesh_map in maps.items()
        }

    @classmethod
    def tearDownClass(cls):
        for server in cls.servers.values():
            server.kill()

    def started(self, name):
        """A server that takes goals, and the file that its map waits for."""
        return self.servers[name].wait_for_server(), self.files.get(name)

    def test_goals_before_the_map(self):
        server, ready = self.started("early")
        waiting = server.send(START, GOAL)
        other = server.send(START, GOAL, concurrency_slot=1)
        wait_until(lambda: waiting.get_goal_status() == other.get_goal_status() == 1, "the start")
        other.cancel()
        self.assertEqual(answer(other)[1].outcome, GetPathResult.CANCELED)
        self.assertEqual(waiting.get_goal_status(), 1)
        ready.touch()
        self.assertEqual(answer(waiting)[0], "SUCCEEDED")
        self.assertEqual(server.stop(), 0, server.output())

    def test_goals_that_do_not_wait_and_shutdown(self):
        server, ready = self.started("hasty")
        state, result = server.ask(START, GOAL)
        self.assertEqual((state, result.outcome), ("ABORTED", GetPathResult.NOT_INITIALIZED))
        self.assertIn("still being loaded", result.message)
        ready.touch()
        wait_until(lambda: server.ask(START, GOAL)[0] == "SUCCEEDED", "the map")
        self.assertEqual(server.stop(), 0, server.output())

    def test_a_server_that_stops_answers_its_goals(self):
        server, file = self.started("stopping")
        handle = server.send(START, GOAL)
        wait_until(lambda: handle.get_goal_status() == 1, "the start")
        server.terminate()
        state, result = answer(handle)
        self.assertEqual((state, result.outcome), ("ABORTED", GetPathResult.STOPPED))
        self.assertEqual(result.message, "the server is shut down")
        file.touch()  # loading goes on, and ends, during the shutdown
        self.assertEqual(server.wait(), 0, server.output())
        self.assertNotIn("no map, goals will fail", server.output())

    def test_no_map(self):
        server, _ = self.started("lost")
        state, result = server.ask(START, GOAL)
        self.assertEqual((state, result.outcome), ("ABORTED", GetPathResult.MAP_ERROR))
        self.assertIn("/nowhere/garden.h5", result.message)
        self.assertEqual(server.stop(), 0, server.output())
        self.assertIn("no map, goals will fail", server.output())

    def test_a_footprint_that_is_none(self):
        """A robot whose shape nobody knows goes nowhere."""
        server, _ = self.started("shapeless")
        state, result = server.ask(START, GOAL)
        self.assertEqual((state, result.outcome), ("ABORTED", GetPathResult.MAP_ERROR))
        self.assertIn("footprint: the 2 corners have no area", result.message)
        self.assertEqual(server.stop(), 0, server.output())


class Suite(unittest.TestSuite):
    def __init__(self):
        load = unittest.defaultTestLoader.loadTestsFromTestCase
        super().__init__([load(GetPathTest), load(MapLoadingTest)])


if __name__ == "__main__":
    rospy.init_node("get_path_test")
    rostest.rosrun("mesh_navigation", "get_path", "get_path_rostest.Suite")
