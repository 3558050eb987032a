#!/usr/bin/python3
"""The real RViz on a virtual screen, with mouse and keyboard: faces are selected and labelled."""
import os
import signal
import subprocess
import tempfile
import time
import unittest
from contextlib import ExitStack, contextmanager
from pathlib import Path
from xmlrpc.client import ServerProxy

import meshio
import numpy as np
import rosgraph
import rospy
import rostest
from geometry_msgs.msg import PointStamped, PoseStamped
from mesh_map.io.map_source import MapSource
from mesh_msgs import zoo
from mesh_msgs.arrays import MeshGeometryStamped
from mesh_msgs.msg import MeshFaceClusterStamped
from mesh_msgs.srv import GetLabeledClusters
from mesh_msgs_hdf5.map_file import MapFile
from osmesa_harness.back_ends import BackEnd, environment_of
from PIL import Image
from std_srvs.srv import Trigger

from mesh_tools_test.demo.processes import environment_with_home, process, wait_until

SCALE = 60  # pixels a meter
SIZE, CELLS = 10.0, 20
SERVER = "/world"
GREEN = (0, 255, 0)
# In meters from the middle of the map. Its squares have sides of 0.5 m: no side of the box and no
# corner is near an edge or diagonal of one.
BOX = np.array([[-1.85, -0.85], [1.35, 1.85]])
ELSEWHERE = np.array([[-3.85, -3.35], [-2.65, -2.15]])

WINDOW = """
Panels:
  - Class: rviz_mesh_plugin/ClusterLabel
    Name: Labels
Visualization Manager:
  Class: ""
  Displays:
%s
  Global Options: {Background Color: 48; 48; 48, Fixed Frame: map, Frame Rate: 10}
  Tools: [{Class: rviz_mesh_plugin/%s}, {Class: rviz/MoveCamera}]
  Views:
    Current: {Class: rviz/TopDownOrtho, Name: Current View, Scale: %g, X: 0, Y: 0, Angle: 0}
Window Geometry: {Width: 1100, Height: 800, X: 0, Y: 0}
"""

LOOK = """Display Type: {Value: Fixed Color, Faces Alpha: 1, Faces Color: 0; 255; 0}
      Show Normals: {Value: false}
      Show Wireframe: {Value: false}"""

TOPICS = f"""
    - Class: rviz_mesh_plugin/TexturedMesh
      Name: Mesh
      Enabled: true
      Value: true
      Geometry Topic: {{geometry}}
      {LOOK.replace('{', '{{').replace('}', '}}')}
    - Class: rviz_mesh_plugin/ClusterLabel
      Name: Labels
      Enabled: true
      Value: true
      Geometry Topic: {{geometry}}
      Labels Topic: {{labels}}/new_cluster_label
"""
SERVED = TOPICS.format(geometry=f"{SERVER}/mesh/geometry", labels=SERVER)

MAP3D = f"""
    - Class: rviz_mesh_plugin/Map3D
      Name: Map3D
      Enabled: true
      Value: true
      Map file path: {{file}}
      ClusterLabel: {{{{Enabled: true, Value: true}}}}
      Mesh:
        Enabled: true
        Value: true
        {LOOK.replace(chr(10), chr(10) + '  ').replace('{', '{{').replace('}', '}}')}
"""


def world():
    """A flat square around the origin."""
    mesh = zoo.grid(cells=CELLS, size=SIZE)
    return mesh.vertices - (SIZE / 2, SIZE / 2, 0.0), mesh.faces


def touching(vertices, faces, box):
    """Faces that have a point in the rectangle, by separating axes in the plane."""
    corners = np.array([[x, y] for x in box[:, 0] for y in box[:, 1]])
    found = []
    for i, face in enumerate(faces):
        triangle = vertices[face][:, :2]
        edges = np.roll(triangle, -1, axis=0) - triangle
        axes = np.vstack([np.eye(2), np.stack([-edges[:, 1], edges[:, 0]], axis=1)])
        a, b = triangle @ axes.T, corners @ axes.T
        if np.all((a.max(axis=0) >= b.min(axis=0)) & (b.max(axis=0) >= a.min(axis=0))):
            found.append(i)
    return found


def wait_for(condition, seconds):
    """What the condition returns as soon as it is true; else what it returned last."""
    end = time.monotonic() + seconds
    value = condition()
    while not value and time.monotonic() < end:
        time.sleep(0.1)
        value = condition()
    return value


def has_ended(pid):
    """Whether there is no such process, or only its entry."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return True
    return status.rpartition(")")[2].split()[0] == "Z"


class Screen:
    """RViz on a screen of its own, and the hands of its user."""

    def __init__(self, child, folder, environment):
        self.child, self.folder, self.environment = child, folder, environment

    def do(self, *arguments):
        """What xdotool prints."""
        command = ["xdotool", *map(str, arguments)]
        return subprocess.run(
            command,
            env=self.environment,
            check=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        ).stdout.decode()

    def pictures(self):
        """What the windows show, the newest of each."""
        for path in self.folder.glob("frame-*.ppm"):
            with Image.open(str(path)) as image:
                yield np.asarray(image.convert("RGB"))

    def try_to(self, *arguments):
        """What xdotool prints; empty where it fails."""
        try:
            return self.do(*arguments)
        except subprocess.CalledProcessError:
            return ""

    def drag(self, begin, end):
        """With the left button."""
        self.drag_along([begin, [(a + b) // 2 for a, b in zip(begin, end)], end])

    def drag_along(self, path, key=None):
        """With the left button, and a key that is held."""
        self.do("mousemove", *path[0], *(["keydown", key] if key else []), "mousedown", 1)
        for at in path[1:]:
            self.do("sleep", 0.2, "mousemove", *at)
        self.do("sleep", 0.2, "mouseup", 1, *(["keyup", key] if key else []))

    def middle(self):
        """Column and row of the middle of the 3D view, once it shows the map."""

        def found():
            shapes = [p.shape[:2] for p in self.pictures() if is_map(p)]
            windows = self.try_to("search", "--maxdepth", 12, "--class", "") if shapes else ""
            for window in windows.split():
                lines = self.try_to("getwindowgeometry", "--shell", window).split()
                values = dict(line.split("=") for line in lines)
                left, top, width, height = [
                    int(values.get(name, 0)) for name in ("X", "Y", "WIDTH", "HEIGHT")
                ]
                if (height, width) in shapes:
                    return np.array([left + 0.5 * width, top + 0.5 * height])
            return None

        place = []
        wait_until(
            lambda: place.append(found()) or place[-1] is not None,
            100,
            "a view of the map",
            [self.child],
        )
        return place[-1]

    def pid(self):
        """Of RViz itself."""
        return int(self.do("search", "--onlyvisible", "--class", "rviz", "getwindowpid").split()[0])


def is_map(picture):
    """Whether at least half of the map is there, in its color or a label's."""
    return (
        np.mean(np.all(picture == GREEN, axis=2)) * picture[:, :, 0].size
        > 0.5 * (SIZE * SCALE) ** 2
    )


class RvizLabelling(unittest.TestCase):
    """Each test has map, server and screen of its own."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("rviz_labelling")

    def setUp(self):
        self.stack = ExitStack()
        self.folder = Path(self.stack.enter_context(tempfile.TemporaryDirectory()))
        self.vertices, self.faces = world()
        ply, self.file = self.folder / "map.ply", self.folder / "map.h5"
        meshio.write_points_cells(ply, self.vertices, [("triangle", self.faces.astype(np.int32))])
        command = ["rosrun", "mesh_msgs_hdf5", "mesh_tool", "import", str(ply), str(self.file)]
        subprocess.run(command, check=True)
        self.published = []
        self.stack.callback(
            rospy.Subscriber(
                "/cluster_label", MeshFaceClusterStamped, self.published.append
            ).unregister
        )

    def tearDown(self):
        self.stack.close()

    def serve(self):
        """A server of the map for everybody."""
        command = ["rosrun", "mesh_msgs_hdf5", "hdf5_map_server", str(self.file)]
        self.stack.enter_context(
            process("server", command + [f"__ns:={SERVER}"], self.folder / "logs")
        )

    @contextmanager
    def rviz(self, name, displays, tool="ClusterLabel"):
        """RViz with these displays on a screen of its own.

        The tool is the first one, and so in use from the start, and again after each use: a key
        that RViz did not hear would let the next drag move the view.
        """
        folder = self.folder / name
        folder.mkdir()
        config = folder / "config.rviz"
        config.write_text(WINDOW % (displays, tool, SCALE), encoding="utf-8")
        variables = environment_with_home(folder, OSMESA_GLX_DUMP=str(folder / "frame"))
        with environment_of(BackEnd.OSMESA_X, variables) as environment:
            command = ["rviz", "-d", str(config)]
            with process("rviz", command, folder, environment) as child:
                yield Screen(child, folder, environment)

    def clusters(self, name_space=SERVER, uuid=""):
        """Label -> faces, as the owner of the labels tells them."""
        ask = rospy.ServiceProxy(name_space + "/get_labeled_clusters", GetLabeledClusters)
        ask.wait_for_service(60)
        return {each.label: sorted(each.face_indices) for each in ask(uuid).clusters}

    def until(self, screen, act, condition, what):
        """Does it, and again where nothing comes of it: the mesh may not be prepared yet."""

        def done():
            act()
            return wait_for(condition, 15.0)

        return wait_until(done, 200, what, [screen.child])

    def label(self, screen, label_class, instance):
        """Selects the box with the mouse, and names it with the keyboard."""
        middle = screen.middle()
        (x0, y1), (x1, y0) = np.round(middle + BOX * (SCALE, -SCALE)).astype(int)
        self.label_selected(screen, lambda: screen.drag((x0, y0), (x1, y1)), label_class, instance)

    def label_selected(self, screen, select_faces, label_class, instance):
        """Names with the keyboard what is selected."""

        def select():
            select_faces()
            screen.do("sleep", 0.5, "key", "Return")

        dialog = ("search", "--onlyvisible", "--name", "^New Label$")
        self.until(screen, select, lambda: screen.try_to(*dialog), "a dialog for the label")
        screen.do("sleep", 0.5, "type", "--delay", 30, label_class)
        screen.do("key", "Tab", "key", "ctrl+a")
        screen.do("type", "--delay", 30, instance)
        screen.do("key", "Return")

    def expected(self):
        return touching(self.vertices, self.faces, BOX)

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

    def pixels(self, screen, places):
        """Columns and rows of places on the map, in meters."""
        middle = screen.middle()
        return [np.round(middle + np.multiply(at, (SCALE, -SCALE))).astype(int) for at in places]

    def near(self, path, radius):
        """Faces that touch a disk along a path: sampled every 5 mm, on the floor."""
        found = set()
        for begin, end in zip(path, path[1:]):
            for share in np.linspace(0.0, 1.0, 1 + int(np.ptp([begin, end], axis=0).max() / 0.005)):
                at = np.add(np.multiply(1.0 - share, begin), np.multiply(share, end))
                box = np.stack([at - 0.7 * radius, at + 0.7 * radius])  # in the disk
                found.update(touching(self.vertices, self.faces, box))
        return found

    def until_labels(self, screen, expected):
        """Waits until the owner has these labels, and no others."""
        wait_until(lambda: self.clusters() == expected, 60, "the labels %s" % expected)

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
