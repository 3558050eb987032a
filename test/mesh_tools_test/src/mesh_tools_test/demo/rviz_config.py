"""The RViz configuration of the demo: mesh with a cost layer, paths, robot, goal, camera."""
import numpy as np
import yaml

SERVER = "/move_base_flex"
ROBOT_FRAME = "base_footprint"
GOAL_TOPIC = "/goal"  # where the MeshGoal tool publishes, too
TRACK_TOPIC, TRACK_COLOR = "/track", (0, 255, 60)
WINDOW = (1280, 960)  # pixels, the whole window of RViz: all of the virtual screen
# In distances from start to goal: the camera's from the middle of its picture, and how far that is
# moved towards the goal, so that the legend at the right covers neither.
CAMERA_DISTANCE, ASIDE = 1.9, 0.12


def mesh_display(layer, limits):
    """The mesh with one cost layer in the rainbow scale between two limits."""
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
            "Color Scale": "Rainbow",
            "Use Custom limits": {
                "Value": True,
                "Vertex Costs Lower Limit": float(limits[0]),
                "Vertex Costs Upper Limit": float(limits[1]),
            },
        },
        "Show Wireframe": {"Value": False},
        "Show Normals": {"Value": False},
    }


def path_display(planner, width, below):
    """The path of a planner, as a line thick enough to see from afar.

    :param below: how many paths shall be on top where they coincide: they are narrower and higher
    """
    topic = f"{SERVER}/{planner.name}/path"
    height = width * (2 - 0.5 * below)
    return line_display(planner.title, topic, planner.color, width * (1 + 0.3 * below), height)


def track_display(width):
    """Where the robot has driven: a broad band just below the path that it followed."""
    return line_display("Track", TRACK_TOPIC, TRACK_COLOR, 3.5 * width, 1.2 * width)


def line_display(name, topic, color, width, height):
    """A nav_msgs/Path as a line of a width, at a height above its poses [m]."""
    return {
        "Class": "rviz/Path",
        "Name": name,
        "Enabled": True,
        "Value": True,
        "Topic": topic,
        "Line Style": "Billboards",
        "Line Width": width,
        "Color": "; ".join(map(str, color)),
        "Offset": {"X": 0, "Y": 0, "Z": height},
        "Pose Style": "None",
        "Buffer Length": 1,
    }


def goal_display(length):
    """The goal pose that was asked for, as an arrow."""
    return {
        "Class": "rviz/Pose",
        "Name": "Goal",
        "Enabled": True,
        "Value": True,
        "Topic": GOAL_TOPIC,
        "Color": "255; 235; 0",
        "Shape": "Arrow",
        "Shaft Length": length,
        "Shaft Radius": 0.08 * length,
        "Head Length": 0.4 * length,
        "Head Radius": 0.2 * length,
    }


def robot_display(length):
    """The robot's frame."""
    return {
        "Class": "rviz/Axes",
        "Name": "Robot",
        "Enabled": True,
        "Value": True,
        "Reference Frame": ROBOT_FRAME,
        "Length": length,
        "Radius": 0.08 * length,
    }


def orbit_view(start, goal):
    """A camera that looks down on start and goal, from the side of the line between them."""
    center = (start + goal) / 2 + ASIDE * (goal - start)
    along = np.arctan2(goal[1] - start[1], goal[0] - start[0])
    return {
        "Class": "rviz/Orbit",
        "Name": "Current View",
        "Target Frame": "<Fixed Frame>",
        "Distance": float(max(CAMERA_DISTANCE * np.linalg.norm(goal - start), 4.0)),
        "Focal Point": dict(zip("XYZ", map(float, center))),
        "Pitch": 0.9,
        "Yaw": float((along - np.pi / 2) % (2 * np.pi)),
        "Near Clip Distance": 0.05,
    }


def rviz_config(start, goal, frame, layer, limits, planners):
    """The whole configuration as YAML text.

    :param start, goal: (3,) positions [m] in the frame of the map
    :param limits: lower and upper limit of the color scale, in the unit of the layer
    :param planners: whose paths are shown, the last on top
    """
    view = orbit_view(np.asarray(start, dtype=float), np.asarray(goal, dtype=float))
    arrow, width = 0.04 * view["Distance"], 0.0025 * view["Distance"]
    paths = [
        path_display(planner, width, len(planners) - number)
        for number, planner in enumerate(planners, start=1)
    ]
    config = {
        "Panels": [
            {
                "Class": "rviz/Displays",
                "Name": "Displays",
                "Splitter Ratio": 0.55,
                "Tree Height": 700,
                "Property Tree Widget": {
                    "Expanded": [
                        "/Mesh1",
                        "/Mesh1/Status1",
                        "/Mesh1/Display Type1",
                        "/Mesh1/Display Type1/Use Custom limits1",
                    ]
                },
            }
        ],
        "Visualization Manager": {
            "Class": "",
            "Displays": [
                mesh_display(layer, limits),
                *paths,
                track_display(width),
                goal_display(1.5 * arrow),
                robot_display(arrow),
            ],
            "Global Options": {
                "Fixed Frame": frame,
                "Background Color": "64; 66; 72",
                "Frame Rate": 10,
            },
            "Tools": [
                {"Class": "rviz/MoveCamera"},
                {"Class": "rviz/FocusCamera"},
                {"Class": "rviz_mesh_plugin/MeshGoal", "Topic": GOAL_TOPIC},
                {"Class": "rviz_mesh_plugin/MeshInspect"},
            ],
            "Views": {"Current": view, "Saved": None},
            "Enabled": True,
            "Name": "root",
            "Value": True,
        },
        "Window Geometry": {
            "Displays": {"collapsed": False},
            "Hide Right Dock": True,
            "Width": WINDOW[0],
            "Height": WINDOW[1],
            "X": 0,
            "Y": 0,
        },
    }
    return yaml.safe_dump(config, sort_keys=False)
