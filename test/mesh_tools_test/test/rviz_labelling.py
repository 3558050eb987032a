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

import meshio
import numpy as np
import rosgraph
import rospy
import rostest
from mesh_msgs import zoo
from mesh_msgs.msg import MeshFaceClusterStamped
from mesh_msgs.srv import GetLabeledClusters
from osmesa_harness.back_ends import BackEnd, environment_of
from PIL import Image

from mesh_tools_test.demo.processes import process, wait_until

SCALE = 60  # pixels a meter
SIZE, CELLS = 10.0, 20
SERVER = "/world"
GREEN = (0, 255, 0)
# In meters from the middle of the map. Its squares have sides of 0.5 m: no side of the box and no
# corner is near an edge or diagonal of one.
BOX = np.array([[-1.85, -0.85], [1.35, 1.85]])

WINDOW = """
Panels:
  - Class: rviz_mesh_plugin/ClusterLabel
    Name: Labels
Visualization Manager:
  Class: ""
  Displays:
%s
  Global Options: {Background Color: 48; 48; 48, Fixed Frame: map, Frame Rate: 30}
  Tools:
    - {Class: rviz/MoveCamera}
    - {Class: rviz_mesh_plugin/ClusterLabel}
  Views:
    Current: {Class: rviz/TopDownOrtho, Name: Current View, Scale: %g, X: 0, Y: 0, Angle: 0}
Window Geometry: {Width: 1100, Height: 800, X: 0, Y: 0}
"""

LOOK = """Display Type: {Value: Fixed Color, Faces Alpha: 1, Faces Color: 0; 255; 0}
      Show Normals: {Value: false}
      Show Wireframe: {Value: false}"""

SERVED = f"""
    - Class: rviz_mesh_plugin/TexturedMesh
      Name: Mesh
      Enabled: true
      Value: true
      Geometry Topic: {SERVER}/mesh/geometry
      {LOOK}
    - Class: rviz_mesh_plugin/ClusterLabel
      Name: Labels
      Enabled: true
      Value: true
      Geometry Topic: {SERVER}/mesh/geometry
      Labels Topic: {SERVER}/new_cluster_label
"""

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

    def view(self):
        """Left, top, width, height of the 3D view, once it shows the map."""

        def found():
            shapes = [p.shape[:2] for p in self.pictures() if is_map(p)]
            for window in self.do("search", "--maxdepth", 12, "--class", "").split():
                try:
                    lines = self.do("getwindowgeometry", "--shell", window).split()
                except subprocess.CalledProcessError:  # gone meanwhile
                    continue
                values = dict(line.split("=") for line in lines)
                place = [int(values[name]) for name in ("X", "Y", "WIDTH", "HEIGHT")]
                if (place[3], place[2]) in shapes:
                    return place
            return None

        return wait_until(found, 100, "a view of the map", [self.child])

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
    def rviz(self, name, displays):
        """RViz with these displays on a screen of its own."""
        folder = self.folder / name
        folder.mkdir()
        config = folder / "config.rviz"
        config.write_text(WINDOW % (displays, SCALE), encoding="utf-8")
        variables = dict(os.environ, OSMESA_GLX_DUMP=str(folder / "frame"), HOME=str(folder))
        with environment_of(BackEnd.OSMESA_X, variables) as environment:
            command = ["rviz", "-d", str(config)]
            with process("rviz", command, folder, environment) as child:
                yield Screen(child, folder, environment)

    def clusters(self, name_space=SERVER):
        """Label -> faces, as the owner of the labels tells them."""
        ask = rospy.ServiceProxy(name_space + "/get_labeled_clusters", GetLabeledClusters)
        ask.wait_for_service(60)
        return {each.label: sorted(each.face_indices) for each in ask("").clusters}

    def label(self, screen, label_class, instance):
        """Selects the box with the mouse, and names it with the keyboard."""
        left, top, width, height = screen.view()
        middle = np.array([left + 0.5 * width, top + 0.5 * height])
        (x0, y1), (x1, y0) = np.round(middle + BOX * (SCALE, -SCALE)).astype(int)
        screen.do("mousemove", middle.astype(int)[0], middle.astype(int)[1])
        time.sleep(0.5)  # as a person does
        screen.do("key", "l")
        time.sleep(0.5)
        before = [picture.tobytes() for picture in screen.pictures()]
        screen.do("mousemove", x0, y0, "mousedown", 1, "sleep", 0.2)
        screen.do("mousemove", (x0 + x1) // 2, (y0 + y1) // 2, "sleep", 0.2)
        screen.do("mousemove", x1, y1, "sleep", 0.2, "mouseup", 1)
        wait_until(
            lambda: [picture.tobytes() for picture in screen.pictures()] != before,
            60,
            "a highlight",
            [screen.child],
        )
        time.sleep(1.0)
        screen.do("key", "Return")
        time.sleep(1.0)
        screen.do("type", "--delay", 30, label_class)
        screen.do("key", "Tab", "key", "ctrl+a")
        screen.do("type", "--delay", 30, instance)
        screen.do("key", "Return")

    def expected(self):
        return touching(self.vertices, self.faces, BOX)

    def test_a_box_is_labelled_and_seen_in_another_rviz(self):
        """The faces are those of brute force, wherever one looks."""
        self.serve()
        with self.rviz("one", SERVED) as one, self.rviz("two", SERVED) as two:
            two.view()
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

    def test_killed_in_the_middle_of_labelling(self):
        """What was confirmed is there after SIGKILL; the next RViz has it."""

        def name_space():
            services = rosgraph.Master("/test").getSystemState()[2]
            found = [name for name, _ in services if name.endswith("/get_labeled_clusters")]
            return found[0].rsplit("/", 1)[0] if found else None

        displays = MAP3D.format(file=self.file)
        with self.rviz("killed", displays) as screen:
            screen.view()
            self.label(screen, "tree", "1")
            wait_until(
                lambda: "tree_1" in self.clusters(name_space()), 60, "the label", [screen.child]
            )
            os.kill(screen.pid(), signal.SIGKILL)
            wait_until(lambda: name_space() is None, 60, "the end of the server")
        with self.rviz("again", displays) as screen:
            wait_until(name_space, 60, "the server", [screen.child])
            self.assertEqual(self.clusters(name_space()), {"tree_1": self.expected()})


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "rviz_labelling", RvizLabelling)
