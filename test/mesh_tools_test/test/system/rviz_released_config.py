#!/usr/bin/python3
"""The real RViz, without a screen, with files as the released plugin wrote them, on real nodes."""
import re
import signal
import subprocess
import tempfile
import time
import unittest
from contextlib import ExitStack, contextmanager
from pathlib import Path

import meshio
import numpy as np
import rospy
import rostest
from mesh_msgs import zoo
from PIL import Image

from mesh_tools_test.demo.processes import environment_with_home, process, wait_until

SERVER = "/move_base_flex/mesh_map"
BACKGROUND, GREEN, MAGENTA = (48, 48, 48), (0, 255, 0), (255, 0, 255)
NOT_OURS = re.compile(r"rospack|media_export|XDG_RUNTIME_DIR|deprecated|deprecation|Stereo")
COMPLAINT = re.compile(r"\bWARN|\bERROR\b|\bError\b|\bFATAL|[Ee]xception|warning", re.ASCII)

WINDOW = """
Visualization Manager:
  Class: ""
  Displays:
%s
  Global Options: {Background Color: 48; 48; 48, Fixed Frame: map, Frame Rate: 30}
  Tools:
    - {Class: rviz/MoveCamera}
  Views:
    Current: {Class: rviz/TopDownOrtho, Name: Current View, Scale: 30, X: 0, Y: 0, Angle: 0}
Window Geometry: {Width: 900, Height: 700}
"""

# The keys of the released plugin, with the older "Mesh Buffer Size".
MESH = """
    - Class: rviz_map_plugin/Mesh
      Display Type:
        Color Scale: Rainbow
        Faces Alpha: 1
        Faces Color: 0; 255; 0
        Material Service Name: get_materials
        Show textured faces only: false
        Texture Service Name: get_texture
        Use Custom limits:
          Value: true
          Vertex Costs Lower Limit: 0
          Vertex Costs Upper Limit: 0.4
        Value: {display_type}
        Vertex Color Service Name: get_vertex_colors
        Vertex Colors Topic: {server}/vertex_colors
        Vertex Costs Topic: {server}/vertex_costs
        Vertex Costs Type: height_diff
      Enabled: true
      Geometry Topic: {server}/mesh
      Mesh Buffer Size: 1
      Name: TexturedMesh
      Show Normals:
        Normals Alpha: 0.5
        Normals Color: 255; 0; 255
        Normals Scaling Factor: 0.3
        Value: false
      Show Wireframe: {{Value: false, Wireframe Alpha: 0.2, Wireframe Color: 0; 0; 0}}
      Value: true
"""

MAP3D = """
    - Class: rviz_map_plugin/Map3D
      Enabled: true
      Map file path: {file}
      Name: Map3D
      Value: true
      ClusterLabel: {{Value: false, Enabled: false}}
      Mesh:
        Display Type: {{Value: Fixed Color, Faces Alpha: 1, Faces Color: 0; 255; 0}}
        Enabled: true
        Show Normals: {{Value: false}}
        Show Wireframe: {{Value: false}}
        Value: true
"""


def share(picture, color):
    """The part of the pixels that have exactly this color."""
    return float(np.mean(np.all(picture == color, axis=2)))


def is_green_map(picture):
    """10 m x 10 m at 30 pixels a meter; flat ground has exactly its color, the ridge is darker."""
    drawn = np.sum(np.any(picture != BACKGROUND, axis=2)) / 300.0**2
    green = np.sum(np.all(picture == GREEN, axis=2)) / 300.0**2
    return abs(drawn - 1.0) < 0.02 and 0.7 < green < 0.85


def map_mesh(cells):
    """A flat square of 10 m around the origin with a ridge of 45 degrees across it."""
    mesh = zoo.grid(cells=cells)
    vertices = mesh.vertices - (5.0, 5.0, 0.0)
    vertices[:, 2] = np.maximum(1.0 - np.abs(vertices[:, 0]), 0.0)
    return vertices, mesh.faces


class RvizReleasedConfig(unittest.TestCase):
    """One map for all; each test has an RViz of its own."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("rviz_released_config")
        cls.stack = ExitStack()
        cls.folder = Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        cls.file = cls.import_map("map", 40)
        layers = [{"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}]
        # The next vertices of the ridge are 0.35 m away and 0.25 m higher or lower.
        rospy.set_param(SERVER, {"layers": layers, "height_diff": {"radius": 0.5}})
        command = ["rosrun", "mesh_map", "mesh_map", "__ns:=/move_base_flex"]
        cls.stack.enter_context(
            process("mesh_map", command + [f"_mesh_file:={cls.file}"], cls.folder / "logs")
        )

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    @classmethod
    def import_map(cls, name, cells):
        """A map file made of a PLY file, as a user does it."""
        ply, file = cls.folder / f"{name}.ply", cls.folder / f"{name}.h5"
        vertices, faces = map_mesh(cells)
        meshio.write_points_cells(ply, vertices, [("triangle", faces.astype(np.int32))])
        subprocess.run(
            ["rosrun", "mesh_msgs_hdf5", "mesh_tool", "import", str(ply), str(file)], check=True
        )
        return file

    @contextmanager
    def rviz(self, name, displays):
        """RViz with these displays; yields (name, process, log file), asserts a peaceful end."""
        folder = self.folder / name
        folder.mkdir()
        (folder / "config.rviz").write_text(WINDOW % displays, encoding="utf-8")
        environment = environment_with_home(folder, OSMESA_GLX_DUMP=str(folder / "frame"))
        command = ["rosrun", "osmesa_harness", "headless", "rviz", "-d"]
        with process("rviz", command + [str(folder / "config.rviz")], folder, environment) as child:
            yield child
            child[1].send_signal(signal.SIGINT)
            status = child[1].wait(timeout=60)
        log = child[2].read_text(encoding="utf-8", errors="replace")
        self.assertEqual(status, 0, log)
        lines = [line for line in log.splitlines() if COMPLAINT.search(line)]
        self.assertEqual([line for line in lines if not NOT_OURS.search(line)], [])

    def see(self, child, looks, what):
        """Waits for a frame that looks so; whatever was drawn before it may look different."""

        def seen():
            for path in child[2].parent.glob("frame-*.ppm"):
                with Image.open(str(path)) as image:
                    if looks(np.asarray(image.convert("RGB"))):
                        return True
            return False

        wait_until(seen, 100, what, [child])

    def test_fixed_color(self):
        """The map in its color: 10 m at 30 pixels a meter, seen from above."""
        displays = MESH.format(server=SERVER, display_type="Fixed Color")
        with self.rviz("fixed_color", displays) as child:
            self.see(child, is_green_map, "a green map of 10 m x 10 m")

    def test_vertex_costs(self):
        """Flat ground is free, the ridge is not; the layer was computed by the map server."""

        def has_its_costs(picture):
            # Where the map is: the legend beside it has all colors of the scale.
            x, y = picture.shape[1] // 2, picture.shape[0] // 2
            map_pixels = picture[y - 145 : y + 145, x - 145 : x + 145]
            ridge, ground = map_pixels[:, 105:185], map_pixels[:, :100]
            red, green, blue = ridge.transpose(2, 0, 1).astype(float)  # pink, in whatever light
            pink = (red > 150) & (abs(green - 0.08 * red) < 15) & (abs(blue - 0.58 * red) < 15)
            colored = not np.any(np.all(map_pixels == GREEN, axis=2))
            return share(ground, MAGENTA) > 0.99 and pink.mean() > 0.3 and colored

        displays = MESH.format(server=SERVER, display_type="Vertex Costs")
        with self.rviz("vertex_costs", displays) as child:
            self.see(child, has_its_costs, "a free ground with a lethal ridge")

    def test_map3d(self):
        """Map3D reads the file itself."""
        with self.rviz("map3d", MAP3D.format(file=self.file)) as child:
            self.see(child, is_green_map, "a green map of 10 m x 10 m")

    def test_interrupt_in_the_middle_of_a_load(self):
        """Ctrl+C whenever it comes: exit code 0, nothing complains."""
        large = self.import_map("large", 700)
        displays = MAP3D.format(file=large) + MESH.format(
            server=SERVER, display_type="Vertex Costs"
        )
        for i, seconds in enumerate((0.0, 0.3, 0.8, 1.5)):
            with self.rviz(f"interrupted_{i}", displays) as child:
                frames = child[2].parent
                wait_until(lambda: list(frames.glob("frame-*.ppm")), 100, "a window", [child])
                time.sleep(seconds)


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "rviz_released_config", RvizReleasedConfig)
