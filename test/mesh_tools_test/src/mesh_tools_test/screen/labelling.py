"""A flat map whose labels are edited in RViz, and what the owner of the labels has of them."""
import subprocess
import tempfile
import unittest
from contextlib import ExitStack, contextmanager
from pathlib import Path

import meshio
import numpy as np
import rospy
from mesh_msgs import zoo
from mesh_msgs.msg import MeshFaceClusterStamped
from mesh_msgs.srv import GetLabeledClusters
from osmesa_harness.back_ends import BackEnd, environment_of

from mesh_tools_test.demo.processes import environment_with_home, process, wait_until
from mesh_tools_test.screen.screen import Screen, wait_for

SCALE = 60  # pixels a meter
SIZE, CELLS = 10.0, 20
SERVER = "/world"
GREEN = (0, 255, 0)
# In meters from the middle of the map. Its squares have sides of 0.5 m: no side of the box and no
# corner is near an edge or diagonal of one.
BOX = np.array([[-1.85, -0.85], [1.35, 1.85]])

WINDOW = """
Panels:
  - Class: rviz_mesh_plugin/%s
    Name: Panel
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


def flat_world():
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


def is_map(picture):
    """Whether at least half of the map is there, in its color or a label's."""
    return (
        np.mean(np.all(picture == GREEN, axis=2)) * picture[:, :, 0].size
        > 0.5 * (SIZE * SCALE) ** 2
    )


class LabellingCase(unittest.TestCase):
    """Each test has map, server and screen of its own."""

    world = staticmethod(flat_world)

    def setUp(self):
        self.stack = ExitStack()
        self.folder = Path(self.stack.enter_context(tempfile.TemporaryDirectory()))
        self.vertices, self.faces = self.world()
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
        """A server of the map for everybody: (name, process, log file)."""
        command = ["rosrun", "mesh_msgs_hdf5", "hdf5_map_server", str(self.file)]
        return self.stack.enter_context(
            process("server", command + [f"__ns:={SERVER}"], self.folder / "logs")
        )

    @contextmanager
    def rviz(self, name, displays, tool="ClusterLabel", panel="ClusterLabel", widgets=None):
        """RViz with these displays on a screen of its own.

        The tool is the first one, and so in use from the start, and again after each use: a key
        that RViz did not hear would let the next drag move the view.
        """
        folder = self.folder / name
        folder.mkdir()
        config = folder / "config.rviz"
        config.write_text(WINDOW % (panel, displays, tool, SCALE), encoding="utf-8")
        variables = environment_with_home(folder, OSMESA_GLX_DUMP=str(folder / "frame"))
        with environment_of(BackEnd.OSMESA_X, variables) as environment:
            command = ["rviz", "-d", str(config)]
            if widgets:
                sheet = folder / "widgets.qss"
                sheet.write_text(widgets.style_sheet(), encoding="utf-8")
                command += ["-stylesheet", str(sheet)]
            with process("rviz", command, folder, environment) as child:
                screen = Screen(child, folder, environment, is_map, widgets)
                with screen.kept_after_failure():
                    yield screen

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

    def pixels(self, screen, places):
        """Columns and rows of places on the map, in meters."""
        middle = screen.middle()
        return [np.round(middle + np.multiply(at, (SCALE, -SCALE))).astype(int) for at in places]

    def until_labels(self, screen, expected):
        """Waits until the owner has these labels, and no others."""
        wait_until(
            lambda: self.clusters() == expected,
            60,
            f"labels {({label: len(faces) for label, faces in expected.items()})}",
            [screen.child],
        )
