#!/usr/bin/python3
"""The real RViz on a virtual screen, with mouse and keyboard: faces are selected and labelled."""
import os
import signal
import time
from xmlrpc.client import ServerProxy

import numpy as np
import rosgraph
import rospy
import rostest
from geometry_msgs.msg import PointStamped, PoseStamped
from mesh_map.io.map_source import MapSource
from mesh_msgs.arrays import MeshGeometryStamped
from mesh_msgs.msg import MeshFaceClusterStamped
from mesh_msgs_hdf5.map_file import MapFile
from std_srvs.srv import Trigger

from mesh_tools_test.demo.processes import process, wait_until
from mesh_tools_test.screen.labelling import (
    GREEN,
    MAP3D,
    SCALE,
    SERVED,
    SERVER,
    TOPICS,
    LabellingCase,
    is_map,
    touching,
)
from mesh_tools_test.screen.screen import has_ended, wait_for

ELSEWHERE = np.array([[-3.85, -3.35], [-2.65, -2.15]])  # as BOX


class RvizLabelling(LabellingCase):
    """Each test has map, server and screen of its own."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("rviz_labelling")

    def test_a_box_is_labelled_and_seen_in_another_rviz(self):
        """The faces are those of brute force, wherever one looks."""
        self.serve()
        with self.rviz("one", SERVED) as one, self.rviz("two", SERVED) as two:
            two.middle()
            self.label(one, "tree", "1")
            wait_until(lambda: "tree_1" in self.clusters(), 60, "the label", [one.child, two.child])
            self.assertEqual(self.clusters(), {"tree_1": self.expected()})
            (message,) = self.published
            self.assertEqual(message.cluster.label, "tree_1")
            self.assertEqual(sorted(message.cluster.face_indices), self.expected())

            def seen():
                return any(
                    np.any(picture[y, x] != GREEN)
                    for picture in two.pictures()
                    for y, x in [(picture.shape[0] // 2 - 20, picture.shape[1] // 2)]
                    if is_map(picture)
                )

            wait_until(seen, 60, "the label in the other RViz", [one.child, two.child])
            for screen in (one, two):  # also where labels are not saved in the map
                screen.child[1].send_signal(signal.SIGINT)
                self.assertEqual(screen.child[1].wait(timeout=60), 0)

    def test_label_manager_has_the_labels_of_a_mesh_without_a_map(self):
        """They are on its disk."""
        message = MeshGeometryStamped(uuid="field")
        message.header.frame_id = "map"
        message.mesh_geometry.vertices = self.vertices
        message.mesh_geometry.faces = self.faces
        publisher = rospy.Publisher("/field", MeshGeometryStamped, queue_size=1, latch=True)
        self.stack.callback(publisher.unregister)
        publisher.publish(message)
        node = ["rosrun", "mesh_msgs_hdf5", "label_manager", f"_folder_path:={self.folder}/labels"]
        displays = TOPICS.format(geometry="/field", labels="/label_manager")
        with process("label_manager", node, self.folder / "logs") as manager:
            with self.rviz("field", displays) as screen:
                self.label(screen, "rock", "7")
                journal = self.folder / "labels/field.labels.journal"
                wait_until(journal.exists, 60, "the label", [screen.child, manager])
                self.assertEqual(
                    self.clusters("/label_manager", "field"), {"rock_7": self.expected()}
                )
                # Undone, it is not there: not even without faces. Then it is there again.
                screen.do("mousemove", *np.round(screen.middle()).astype(int), "key", "ctrl+z")

                def labels():
                    return self.clusters("/label_manager", "field")

                wait_until(lambda: labels() == {}, 60, "the end of the label", [screen.child])
                screen.do("key", "ctrl+y")
                wait_until(
                    lambda: labels() == {"rock_7": self.expected()},
                    60,
                    "the label once more",
                    [screen.child],
                )
        with process("label_manager", node, self.folder / "logs"):
            self.assertEqual(self.clusters("/label_manager", "field"), {"rock_7": self.expected()})

    def test_labels_of_a_refined_mesh_are_those_of_its_parent(self):
        """A box that is drawn on it is stored as faces of the file, and those are seen on it."""
        self.serve()
        node = ["rosrun", "mesh_map", "mesh_map", f"_mesh_file:={self.file}"]
        node.append("_max_edge_length:=0.3")
        displays = TOPICS.format(geometry="/mesh_map/mesh", labels="/mesh_map")
        with process("mesh_map", node, self.folder / "logs") as mesh_map:
            with self.rviz("refined", displays) as screen:
                programs = [screen.child, mesh_map]
                self.label(screen, "tree", "1")
                wait_until(lambda: "tree_1" in self.clusters(), 60, "the label", programs)
                self.assertEqual(self.clusters(), {"tree_1": self.expected()})
                derived = MapSource(str(self.file)).make_map(max_edge_length=0.3).geometry.derived
                self.assertGreater(len(derived.faces), 3 * len(self.faces))
                parts = derived.faces_of(self.expected()).tolist()
                self.assertEqual(self.clusters("/mesh_map"), {"tree_1": parts})

                # The other way round.
                owner = rospy.Publisher(
                    SERVER + "/cluster_label", MeshFaceClusterStamped, queue_size=1
                )
                self.stack.callback(owner.unregister)
                wait_until(owner.get_num_connections, 60, "the owner of the labels", programs)
                stone = MeshFaceClusterStamped(uuid=derived.parent_uuid, override=True)
                stone.cluster.label = "stone_1"
                faces = touching(self.vertices, self.faces, ELSEWHERE)
                stone.cluster.face_indices = faces
                owner.publish(stone)
                x, y = np.round(ELSEWHERE.mean(axis=1) * (SCALE, -SCALE)).astype(int)

                def seen():
                    return any(
                        np.any(
                            picture[picture.shape[0] // 2 + y, picture.shape[1] // 2 + x] != GREEN
                        )
                        for picture in screen.pictures()
                        if is_map(picture)
                    )

                wait_until(seen, 60, "the label of the parent", programs)
                saved = rospy.ServiceProxy("/mesh_map/save_map", Trigger)()
                self.assertTrue(saved.success, saved.message)
                labels = MapFile(self.file).labels()
                found = {text: label.faces.tolist() for text, label in labels.items()}
                self.assertEqual(found, {"tree_1": self.expected(), "stone_1": faces})
                screen.child[1].send_signal(signal.SIGINT)
                self.assertEqual(screen.child[1].wait(timeout=60), 0)

    def test_goal(self):
        """Where the button was pressed, towards where it was released."""
        goals, subscribers = [], []

        def subscribe():
            """Anew where it has no connection: rospy asks a publisher for one but once."""
            if subscribers and not subscribers[-1].get_num_connections():
                subscribers.pop().unregister()
            if not subscribers:
                subscribers.append(rospy.Subscriber("/goal", PoseStamped, goals.append))

        self.stack.callback(lambda: [subscriber.unregister() for subscriber in subscribers])
        self.serve()
        with self.rviz("goal", SERVED, "MeshGoal") as screen:
            middle = screen.middle()
            begin, end = np.round(middle + ((90, 60), (190, -40))).astype(int)

            def set_goal():
                subscribe()
                wait_for(lambda: subscribers[0].get_num_connections(), 15.0)
                screen.drag(begin, end)

            self.until(screen, set_goal, lambda: goals, "a goal")
        goal = goals[0]
        x, y = (begin + 0.5 - middle) * (1.0, -1.0) / SCALE
        self.assertEqual(goal.header.frame_id, "map")
        place, turn = goal.pose.position, goal.pose.orientation
        np.testing.assert_allclose([place.x, place.y, place.z], [x, y, 0.0], atol=1e-4)
        half = np.pi / 8.0  # of 45 degrees
        np.testing.assert_allclose([turn.x, turn.y], [0.0, 0.0], atol=1e-6)
        np.testing.assert_allclose([turn.z, turn.w], [np.sin(half), np.cos(half)], atol=1e-4)

    def near(self, path, radius):
        """Faces that touch a disk along a path: sampled every 5 mm, on the floor."""
        found = set()
        for begin, end in zip(path, path[1:]):
            for share in np.linspace(0.0, 1.0, 1 + int(np.ptp([begin, end], axis=0).max() / 0.005)):
                at = np.add(np.multiply(1.0 - share, begin), np.multiply(share, end))
                box = np.stack([at - 0.7 * radius, at + 0.7 * radius])  # in the disk
                found.update(touching(self.vertices, self.faces, box))
        return found

    def test_brush_lasso_and_flood_are_labelled_undone_and_redone(self):
        """By mouse and keys alone; what the owner has tells what they did."""
        self.serve()
        with self.rviz("hands", SERVED) as screen:
            lasso_path = [(-2.1, -1.1), (1.1, -1.1), (-0.4, 2.2)]
            lasso = self.pixels(screen, lasso_path + lasso_path[:1])
            self.label_selected(
                screen,
                lambda: (screen.do("key", "2"), screen.drag_along(lasso)),
                "lasso",
                "1",
            )
            wait_until(lambda: "lasso_1" in self.clusters(), 60, "the label", [screen.child])
            labels = self.clusters()
            inner = np.array([[-0.6, -0.6], [0.0, 0.6]])
            self.assertLessEqual(
                set(touching(self.vertices, self.faces, inner)), set(labels["lasso_1"])
            )
            outer = np.array([[-2.2, -1.2], [1.2, 2.3]])
            self.assertLessEqual(
                set(labels["lasso_1"]), set(touching(self.vertices, self.faces, outer))
            )

            # Two events far apart: the brush follows the way between.
            path = [(-3.3, 3.1), (3.2, 2.7)]
            brush = self.pixels(screen, path)
            self.label_selected(screen, lambda: screen.drag_along(brush, "ctrl"), "brush", "1")
            wait_until(lambda: "brush_1" in self.clusters(), 60, "the label", [screen.child])
            labels = self.clusters()
            self.assertLessEqual(self.near(path, 0.9), set(labels["brush_1"]))
            outer = np.array([[-4.4, 1.6], [4.3, 4.2]])
            self.assertLessEqual(
                set(labels["brush_1"]), set(touching(self.vertices, self.faces, outer))
            )

            (place,) = self.pixels(screen, [(-3.1, -3.1)])
            self.label_selected(
                screen,
                lambda: screen.do("key", "3", "mousemove", *place, "sleep", 0.2, "click", 1),
                "flood",
                "1",
            )
            wait_until(lambda: "flood_1" in self.clusters(), 60, "the label", [screen.child])
            flooded = self.clusters()
            self.assertEqual(flooded, {**labels, "flood_1": list(range(len(self.faces)))})

            # The view has the keys while the cursor is on it.
            undo, redo = ("key", "ctrl+z"), ("key", "ctrl+shift+z")
            before = dict(labels)
            del before["brush_1"]
            screen.do("mousemove", *place)
            screen.do(*undo)
            self.until_labels(screen, labels)
            screen.do(*undo)  # that flood was selected
            screen.do(*undo)
            self.until_labels(screen, before)
            screen.do(*redo)
            self.until_labels(screen, labels)
            screen.do(*redo)
            screen.do(*redo)
            self.until_labels(screen, flooded)
            saved = rospy.ServiceProxy(SERVER + "/save_map", Trigger)()
            self.assertTrue(saved.success, saved.message)
            screen.do(*undo)
            self.until_labels(screen, labels)
            saved = rospy.ServiceProxy(SERVER + "/save_map", Trigger)()
            self.assertTrue(saved.success, saved.message)
            in_file = MapFile(self.file).labels()
            self.assertEqual(
                {text: label.faces.tolist() for text, label in in_file.items()}, labels
            )
            screen.child[1].send_signal(signal.SIGINT)
            self.assertEqual(screen.child[1].wait(timeout=60), 0)

    def test_inspect(self):
        """The point that is clicked at, on its topic."""
        points, subscribers = [], []

        def subscribe():
            if subscribers and not subscribers[-1].get_num_connections():
                subscribers.pop().unregister()
            if not subscribers:
                subscribers.append(rospy.Subscriber("/clicked_point", PointStamped, points.append))

        self.stack.callback(lambda: [subscriber.unregister() for subscriber in subscribers])
        self.serve()
        with self.rviz("inspect", SERVED, "MeshInspect") as screen:
            (place,) = self.pixels(screen, [(1.3, -0.8)])
            middle = screen.middle()

            def click():
                subscribe()
                wait_for(lambda: subscribers[0].get_num_connections(), 15.0)
                screen.do("mousemove", *place, "sleep", 0.2, "click", 1)

            self.until(screen, click, lambda: points, "a point")
        x, y = (place + 0.5 - middle) * (1.0, -1.0) / SCALE
        point = points[0].point
        self.assertEqual(points[0].header.frame_id, "map")
        np.testing.assert_allclose([point.x, point.y, point.z], [x, y, 0.0], atol=1e-4)

    def test_killed_in_the_middle_of_labelling(self):
        """What was confirmed is there after SIGKILL; the next RViz has it."""

        master = rosgraph.Master("/test")

        def servers():
            services = master.getSystemState()[2]
            return [one for one in services if one[0].endswith("/get_labeled_clusters")]

        def name_space():
            found = servers()
            return found[0][0].rsplit("/", 1)[0] if found else None

        displays = MAP3D.format(file=self.file)
        with self.rviz("killed", displays) as screen:
            screen.middle()
            self.label(screen, "tree", "1")
            wait_until(
                lambda: "tree_1" in self.clusters(name_space()), 60, "the label", [screen.child]
            )
            screen.do("key", "ctrl+q")
            time.sleep(2.0)
            self.assertIsNone(screen.child[1].poll(), "it asks before labels are not saved")
            ((_, (node,)),) = servers()
            server = ServerProxy(master.lookupNode(node)).getPid("/test")[2]
            os.kill(screen.pid(), signal.SIGKILL)
            wait_until(lambda: name_space() is None, 60, "the end of the server")
            wait_until(
                lambda: has_ended(server), 60, "the end of its process, which writes the file"
            )
        with self.rviz("again", displays) as screen:
            wait_until(name_space, 60, "the server", [screen.child])
            self.assertEqual(self.clusters(name_space()), {"tree_1": self.expected()})


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "rviz_labelling", RvizLabelling)
