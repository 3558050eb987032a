#!/usr/bin/python3
"""All planners through the server: outcomes, frames, topics, parameters that change."""

import random
import time
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from actionlib_msgs.msg import GoalID
from dynamic_reconfigure.client import Client
from dynamic_reconfigure.msg import Config, DoubleParameter
from dynamic_reconfigure.srv import Reconfigure
from geometry_msgs.msg import TransformStamped
from mbf_msgs.msg import GetPathActionGoal, GetPathGoal, GetPathResult
from server_process import STATES, ServerProcess, Topics, positions, stamped, write_map
from visualization_msgs.msg import Marker

from mesh_msgs import zoo
from mesh_msgs.arrays import MeshVertexCostsStamped
from mesh_msgs.testing import wait_until

NAME = "planners_server"
TYPES = {
    "dijkstra": "dijkstra_mesh_planner/DijkstraMeshPlanner",
    "wave": "wave_front_planner/WaveFrontPlanner",
    "cvp": "cvp_mesh_planner/CVPMeshPlanner",
    "mmp": "mmp_planner/MMPPlanner",
}
PLANNERS = [{"name": name, "type": kind} for name, kind in TYPES.items()]
GRID = zoo.grid(cells=20)
ISLAND = zoo.grid(cells=4, size=2.0)
START, GOAL = (2.1, 2.2, 0.0), (8.1, 7.1, 0.0)
BLOCKED = 220  # the vertex in the middle, at (5, 5)
PATIENT = {"layers": [{"name": "patient", "type": "odd/PatientLayer"}]}


class Islands:
    """The grid, and a smaller one far from it."""

    vertices = np.concatenate([GRID.vertices, ISLAND.vertices + np.float32([20, 0, 0])])
    faces = np.concatenate([GRID.faces, ISLAND.faces + len(GRID.vertices)])


class Newest:
    """The newest message on a topic of the map by its namespace or type."""

    def __init__(self, topic, kind, key):
        self.of = {}
        self._subscriber = rospy.Subscriber(
            f"/{NAME}/mesh_map/{topic}",
            kind,
            lambda message: self.of.update({getattr(message, key): message}),
            queue_size=10,
        )


class PlannersTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        mesh_map = dict(PATIENT, mesh_file=write_map(Islands))
        mesh_map["patient"] = {"file": mesh_map["mesh_file"], "lethal_vertex": BLOCKED}
        fields = {"publish_vector_field": True, "publish_face_vectors": True}
        cls.server = ServerProcess(
            NAME,
            planners=PLANNERS,
            mesh_map=mesh_map,
            tf_timeout=1.0,
            dijkstra=fields,
            wave=fields,
            mmp=fields,
        )

    @classmethod
    def tearDownClass(cls):
        try:
            status = cls.server.stop()
        finally:
            cls.server.kill()
        assert status == 0, status
        assert "Traceback" not in cls.server.output(), cls.server.output()

    def check(self, given, outcome, *words):
        state, result = given
        self.assertEqual(result.outcome, outcome, result.message)
        expected = {0: "SUCCEEDED", GetPathResult.CANCELED: "PREEMPTED"}
        self.assertEqual(state, expected.get(outcome, "ABORTED"))
        for word in words:
            self.assertIn(word, result.message)
        if outcome:
            self.assertEqual((result.path.poses, result.cost), ([], 0.0))
        return result

    def client(self, name=""):
        client = Client(f"/{NAME}/{name}".rstrip("/"), timeout=30)
        self.addCleanup(client.close)
        client.get_configuration(30)
        return client

    def test_outcomes(self):
        middle = (5.1, 5.0, 0.0)
        for name in TYPES:
            with self.subTest(name):
                for start, goal, outcome, words in (
                    (START, GOAL, 0, ["path of "]),
                    (START, (2.12, 2.21, 0), 0, ["path of 0.02 m with 2 poses"]),
                    ((2, 2, 2), GOAL, 52, ["start", "2.00 m from the map"]),
                    (START, (8, 7, -3), 53, ["goal", "3.00 m from the map"]),
                    (middle, GOAL, 52, ["start", "lethal in layer patient"]),
                    (START, middle, 53, ["goal", "lethal in layer patient"]),
                    (START, (21, 1, 0), 54, ["start is in component", "goal in component"]),
                    ((np.nan, 1, 0), GOAL, 52, ["not finite"]),
                    (START, (1, np.inf, 0), 53, ["not finite"]),
                ):
                    self.check(self.server.ask(start, goal, planner=name), outcome, *words)
                near = self.server.ask(START, middle, planner=name, tolerance=1.0)
                end = positions(self.check(near, 0, "tolerance 1.00 m").path)[-1]
                self.assertLess(np.linalg.norm(end - middle), 1.0)

    def test_other_frames(self):
        """Start and goal in frames of their own, one turned about z, and the robot's pose."""
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        broadcaster.sendTransform(
            [transform("odom", 10, 10, half_turn=True), transform("base_link", 2.1, 2.2)]
        )
        goal = stamped((1.9, 2.9, 0.0), "odom")
        start = stamped((0.0, 0.0, 0.1), "base_link")
        wait_until(lambda: self.server.ask(None, goal)[1].outcome != 57, "TF")
        for name in TYPES:
            for begin in (start, None):
                result = self.check(self.server.ask(begin, goal, planner=name), 0)
                self.assertEqual(result.path.header.frame_id, "map")
                ends = positions(result.path)[[0, -1]]
                np.testing.assert_allclose(ends, [START, GOAL], atol=1e-5)
                last = result.path.poses[-1].pose.orientation
                self.assertAlmostEqual(abs(last.z), 1.0, places=6)

    def test_one_goal_from_many_starts(self):
        """Fields are kept between plans: each path is as if it was the only one."""
        starts = [(x, y, 0.0) for x, y in np.random.default_rng(0).uniform(0.3, 9.7, (8, 2))]
        for name in TYPES:
            costs = {}
            for number, start in enumerate(starts * 2):
                straight = np.linalg.norm(np.subtract(start, GOAL))
                slot = number % 3
                given = self.server.ask(start, GOAL, planner=name, concurrency_slot=slot)
                cost = self.check(given, 0).cost
                self.assertGreater(cost, straight - 1e-4)
                self.assertLess(cost, 1.09 * straight + 1.5)  # some have to go round the middle
                self.assertAlmostEqual(costs.setdefault(start, cost), cost, places=4)

    def test_what_a_plan_shows(self):
        fields = Newest("vector_field", Marker, "ns")
        costs = Newest("vertex_costs", MeshVertexCostsStamped, "type")

        def shown():
            return {name: marker.action for name, marker in fields.of.items()}

        def potential():
            message = costs.of.get("Potential")
            return None if message is None else np.asarray(message.mesh_vertex_costs.costs)

        def reached(value):
            return value is not None and np.isfinite(value).any()

        for name in ("dijkstra", "wave", "mmp"):
            given = self.server.ask(START, GOAL, planner=name)
            self.check(given, 0)
            both = {"vector_field": Marker.ADD, "face_vectors": Marker.ADD}
            wait_until(lambda: shown() == both and reached(potential()), f"the field of {name}")
            values = potential()
            self.assertTrue(np.isinf(values[[BLOCKED, -1]]).all())
            nearest = np.argmin(np.linalg.norm(GRID.vertices - np.float32(GOAL), axis=1))
            self.assertLess(values[nearest], 0.3)
            self.assertGreater(len(fields.of["face_vectors"].points), 100)
            gone = dict.fromkeys(both, Marker.DELETE)
            # A plan that fails takes away what the one before has shown.
            self.check(self.server.ask(START, (8, 7, -3), planner=name), 53)
            wait_until(lambda: shown() == gone, "the field's end")
            wait_until(lambda: not reached(potential()), "no potential")
        client = self.client("wave")
        self.check(self.server.ask(START, GOAL, planner="wave"), 0)
        wait_until(lambda: shown() == both, "the field")
        client.update_configuration({"publish_face_vectors": False})
        self.check(self.server.ask(START, GOAL, planner="wave"), 0)
        wait_until(lambda: shown() == dict(both, face_vectors=Marker.DELETE), "one of them")
        client.update_configuration({"publish_face_vectors": True})
        # What is not within one component is not reached, and that is shown, too.
        self.check(self.server.ask(START, (21, 1, 0), planner="cvp"), 54)
        wait_until(lambda: set(shown().values()) == {Marker.DELETE}, "no field")

    def test_parameters_that_change(self):
        for name in TYPES:
            client = self.client(name)
            described = {one["name"]: one for one in client.get_parameter_descriptions(30)}
            self.assertEqual(
                (described["cost_limit"]["min"], described["cost_limit"]["max"]), (0, 10)
            )
            self.assertEqual(client.update_configuration({"cost_limit": 0.25})["cost_limit"], 0.25)
            self.assertEqual(rospy.get_param(f"/{NAME}/{name}/cost_limit"), 0.25)
            self.assertEqual(client.update_configuration({"cost_limit": 99.0})["cost_limit"], 10.0)
            service = rospy.ServiceProxy(f"/{NAME}/{name}/set_parameters", Reconfigure)
            nan = service(Config(doubles=[DoubleParameter("cost_limit", np.nan)])).config
            found = {one.name: one.value for one in nan.doubles}
            self.assertEqual(found["cost_limit"], 10.0)
            self.check(self.server.ask(START, GOAL, planner=name), 0)
        client = self.client("wave")
        counts = []
        for step in (0.05, 1.0):
            client.update_configuration({"step_width": step})
            path = self.check(self.server.ask(START, GOAL, planner="wave"), 0).path
            counts.append(len(path.poses))
        self.assertGreater(counts[0], 4 * counts[1])
        self.assertIn("cost_limit is 99", self.server.output())

    def test_parameters_of_the_node(self):
        client = self.client()
        values = client.get_configuration(30)
        self.assertEqual((values["planner_patience"], values["planner_max_retries"]), (5.0, -1))
        changed = client.update_configuration({"planner_patience": -1.0, "planner_max_retries": 3})
        self.assertEqual((changed["planner_patience"], changed["planner_max_retries"]), (0.0, 3))
        self.check(self.server.ask(START, GOAL), 0)
        client.update_configuration({"planner_patience": 5.0, "planner_max_retries": -1})
        self.assertEqual(rospy.get_param(f"/{NAME}/planner_patience"), 5.0)


class LargeMapTest(unittest.TestCase):
    def test_cancels_during_plans(self):
        """At any moment a cancel leaves the planner able to give the plan it gave before."""
        world = zoo.outdoor_world(faces=150_000)
        server = ServerProcess(
            "large_server", planners=PLANNERS, mesh_map={"mesh_file": write_map(world)}
        )
        self.addCleanup(server.kill)
        pauses = random.Random(1)
        corner = world.vertices[:, :2].max() - 1.0
        heights = [height_at(world, place) for place in (-corner, corner)]
        start, goal = (-corner, -corner, heights[0]), (corner, corner, heights[1])
        topics = Topics("/large_server/get_path")
        for name in TYPES:
            state, first = server.ask(start, goal, planner=name)
            self.assertEqual((state, first.outcome), ("SUCCEEDED", 0), first.message)
            for number in range(12):
                other = (goal[0] - 0.1 * number, goal[1], goal[2])
                key = f"{name} {number}"
                canceled = GetPathActionGoal(goal_id=GoalID(id=key))
                canceled.goal = GetPathGoal(planner=name, use_start_pose=True)
                canceled.goal.start_pose = stamped(start)
                canceled.goal.target_pose = stamped(other)
                topics.goal.publish(canceled)
                time.sleep(pauses.choice([0.0, pauses.uniform(0, 0.05)]))
                topics.cancel.publish(canceled.goal_id)
                wait_until(lambda: key in topics.results, "an answer")
                ended = topics.results[key]
                found = STATES[ended.status.status], ended.result.outcome
                stopped = {("PREEMPTED", 51), ("RECALLED", 51)}
                self.assertIn(found, {("SUCCEEDED", 0)} | stopped, ended.result.message)
            state, again = server.ask(start, goal, planner=name)
            self.assertEqual(again.outcome, 0, again.message)
            self.assertAlmostEqual(again.cost, first.cost, delta=1e-4 * first.cost)
        # The end comes while plans run, are answered, and are shown.
        for slot in range(30):
            name = list(TYPES)[slot % len(TYPES)]
            server.send(start, goal, planner=name, concurrency_slot=slot)
        server.terminate()
        self.assertEqual(server.wait(), 0)
        self.assertNotIn("Traceback", server.output())
        self.assertNotIn("outcome 63, \n", server.output())


def height_at(world, place):
    """z of the lowest vertex near a place on the diagonal."""
    near = np.linalg.norm(world.vertices[:, :2] - np.float32(place), axis=1) < 0.5
    return float(world.vertices[near, 2].min())


def transform(child, x, y, half_turn=False):
    """A static transform from the map to a child frame."""
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = "map", child
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y = x, y
    rotation.z, rotation.w = (1.0, 0.0) if half_turn else (0.0, 1.0)
    return message


class Suite(unittest.TestSuite):
    def __init__(self):
        load = unittest.defaultTestLoader.loadTestsFromTestCase
        super().__init__([load(PlannersTest), load(LargeMapTest)])


if __name__ == "__main__":
    rospy.init_node("planners_test")
    rostest.rosrun("mesh_navigation", "planners", "planners_rostest.Suite")
