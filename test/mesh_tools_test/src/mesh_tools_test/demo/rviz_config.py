"""The RViz configurations of the demo: mesh with a cost layer, path, robot, camera."""
import yaml

from mesh_tools_test.demo import isolines, robot_model
from mesh_tools_test.demo.orbit_camera import whole_map
from mesh_tools_test.demo.planners import PLANNERS

SERVER = "/move_base_flex"
GOAL_TOPIC = "/goal"  # where the MeshGoal tool publishes, too
TRACK_TOPIC, TRACK_COLOR = "/track", (240, 228, 66)
HALO, BACKGROUND = (255, 255, 255), (232, 235, 239)  # light, for print; no widget has this color
COLOR_SCALE = "Viridis"  # backwards, so that what is cheap is bright
WINDOW = (1280, 960)  # pixels, the whole window of RViz: all of the virtual screen
VIEW = (1248, 869)  # pixels of the 3D view in it, where no panel is open; a few more or less
PANEL = 348  # pixels of the tree of displays, where it is
TREE = {
    "Class": "rviz/Displays",
    "Name": "Displays",
    "Splitter Ratio": 0.55,
    "Tree Height": 700,
    "Property Tree Widget": {"Expanded": ["/Mesh1/Display Type1"]},
}
# Pixels of lines; the track lies on the path, which the robot follows, and leaves both its edges.
PATH, HALO_WIDTH, TRACK, ISOLINE = 9.0, 15.0, 2.4, 1.3
ABOVE = 8.0  # pixels from the surface up to the lowest line: more than half as wide


def mesh_display(layer, limits):
    """The mesh with one cost layer in colors between two limits."""
    return {
        "Class": "rviz_mesh_plugin/TexturedMesh",
        "Name": "Mesh",
        "Enabled": True,
        "Value": True,
        "Geometry Topic": f"{SERVER}/mesh_map/mesh",
        "Display Type": {
            "Value": "Vertex Costs",
            "Vertex Costs Topic": f"{SERVER}/mesh_map/vertex_costs",
            "Vertex Costs Type": layer,
            "Color Scale": COLOR_SCALE,
            "Invert Colors": True,
            "Use Custom limits": {
                "Value": True,
                "Vertex Costs Lower Limit": float(limits[0]),
                "Vertex Costs Upper Limit": float(limits[1]),
            },
        },
        "Show Wireframe": {"Value": False},
        "Show Normals": {"Value": False},
    }


def path_displays(planner, pixel, enabled):
    """The path of a planner: a broad dark line, and a wider light one just below it.

    :param pixel: how long one is [m]
    """
    topic, title = f"{SERVER}/{planner.name}/path", planner.title
    halo, width = HALO_WIDTH * pixel, PATH * pixel
    return [
        line_display(f"{title}, halo", topic, HALO, halo, ABOVE * pixel, enabled),
        line_display(title, topic, planner.color, width, (ABOVE + 0.4) * pixel, enabled),
    ]


def track_display(pixel, enabled):
    """Where the robot has driven: a narrow line on the path that it followed."""
    width, height = TRACK * pixel, (ABOVE + 2.5) * pixel
    return line_display("Track", TRACK_TOPIC, TRACK_COLOR, width, height, enabled)


def isolines_display(enabled):
    """Lines of equal cost on the potential that is shown."""
    return {
        "Class": "rviz/Marker",
        "Name": "Lines of equal cost",
        "Enabled": enabled,
        "Value": enabled,
        "Marker Topic": isolines.TOPIC,
    }


def line_display(name, topic, color, width, height, enabled):
    """A nav_msgs/Path as a line of a width, at a height above its poses [m]."""
    return {
        "Class": "rviz/Path",
        "Name": name,
        "Enabled": enabled,
        "Value": enabled,
        "Topic": topic,
        "Line Style": "Billboards",
        "Line Width": width,
        "Color": "; ".join(map(str, color)),
        "Offset": {"X": 0, "Y": 0, "Z": height},
        "Pose Style": "None",
        "Buffer Length": 1,
    }


def goal_display(length, enabled):
    """The goal pose that was asked for, as an arrow."""
    return {
        "Class": "rviz/Pose",
        "Name": "Goal",
        "Enabled": enabled,
        "Value": enabled,
        "Topic": GOAL_TOPIC,
        "Color": "204; 121; 167",
        "Shape": "Arrow",
        "Shaft Length": length,
        "Shaft Radius": 0.08 * length,
        "Head Length": 0.4 * length,
        "Head Radius": 0.2 * length,
    }


def robot_display():
    """The robot as its model says."""
    return {
        "Class": "rviz/RobotModel",
        "Name": "Robot",
        "Enabled": True,
        "Value": True,
        "Robot Description": robot_model.PARAMETER,
    }


def picture_config(picture, limits, camera, frame):
    """The configuration for a picture, without a panel, as YAML text.

    :param picture: what it shows, a pictures.Picture
    :param limits: of its colors, in the unit of the layer
    :param camera: an OrbitCamera for VIEW
    """
    pixel = camera.pixel
    paths = path_displays(picture.planner, pixel, True) if picture.planner else []
    displays = [mesh_display(picture.layer, limits), *paths, robot_display()]
    if picture.track:
        displays.append(track_display(pixel, True))
    if picture.limits is None:
        displays.append(isolines_display(True))
    return _config(displays, camera, frame, [])


def user_config(picture, vertices, start, goal, frame):
    """The configuration for the user: as a picture, and with all that can be shown in the tree.

    :param vertices: (V, 3) m, of the map; start, goal: (3,) m
    """
    camera = whole_map(vertices, start, goal, (VIEW[0] - PANEL, VIEW[1]))
    pixel = camera.pixel
    displays = [mesh_display(picture.layer, picture.limits)]
    for planner in PLANNERS:
        displays += path_displays(planner, pixel, planner is picture.planner)
    displays += [track_display(pixel, True), isolines_display(False)]
    displays += [goal_display(40 * pixel, True), robot_display()]
    return _config(displays, camera, frame, [TREE])


def _config(displays, camera, frame, panels):
    config = {
        "Panels": panels,
        "Visualization Manager": {
            "Class": "",
            "Displays": displays,
            "Global Options": {
                "Fixed Frame": frame,
                "Background Color": "; ".join(map(str, BACKGROUND)),
                "Frame Rate": 10,
            },
            "Tools": [
                {"Class": "rviz/MoveCamera"},
                {"Class": "rviz/FocusCamera"},
                {"Class": "rviz_mesh_plugin/MeshGoal", "Topic": GOAL_TOPIC},
                {"Class": "rviz_mesh_plugin/MeshInspect"},
            ],
            "Views": {"Current": camera.view(), "Saved": None},
            "Enabled": True,
            "Name": "root",
            "Value": True,
        },
        "Window Geometry": {
            "Hide Right Dock": True,
            "Width": WINDOW[0],
            "Height": WINDOW[1],
            "X": 0,
            "Y": 0,
        },
    }
    return yaml.safe_dump(config, sort_keys=False)
