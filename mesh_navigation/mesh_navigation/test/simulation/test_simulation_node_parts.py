"""What the node surface_robot is made of, without ROS running."""

import itertools
import math
import subprocess
import sys

import numpy as np
import pytest
from geometry_msgs.msg import Twist
from visualization_msgs.msg import Marker, MarkerArray

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import read_parameters
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_navigation.base.messages import bare_pose, pose_from_message, velocity_of
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import Velocity
from mesh_navigation.simulation import robot_messages
from mesh_navigation.simulation.obstacle_messages import ObstacleMarkers
from mesh_navigation.simulation.obstacles import Obstacle
from mesh_navigation.simulation.parameters import PARAMETERS, check_frames
from mesh_navigation.simulation.placing import initial_pose, put_down

STOREYS = MeshMap(zoo.two_storeys().vertices, zoo.two_storeys().faces)
GRID = MeshMap(zoo.grid().vertices, zoo.grid().faces)


def test_poses_are_put_on_the_storey_that_is_nearest():
    low, high = (float(z) for z in np.unique(STOREYS.vertices[:, 2])[[0, -1]])
    middle = STOREYS.vertices.astype(np.float64).mean(axis=0)
    x, y = middle[0] + 0.1, middle[1] + 0.1
    for z, expected in ((low - 9, low), (low + 0.4 * (high - low), low), (high + 3, high)):
        found = put_down(STOREYS, Pose.at((x, y, z), 1.0))
        assert found.position == pytest.approx([x, y, expected], abs=1e-5)
        assert found.heading == pytest.approx([math.cos(1), math.sin(1), 0])
    there = Pose.at((x, y, high + 0.01))
    assert put_down(STOREYS, there).position.tolist() == there.position.tolist()


def test_poses_beside_the_map_are_put_on_its_border():
    assert put_down(GRID, Pose.at((30, 5.5, 2))).position == pytest.approx([10, 5.5, 0])


@pytest.mark.parametrize(
    "given, position, yaw",
    [
        ((), (5, 5, 0), 0),
        ((2, 3), (2, 3, 0), 0),
        ((2, 3, 0.01), (2, 3, 0.01), 0),
        (("2", "3", "0", "1.5"), (2, 3, 0), 1.5),
    ],
)
def test_where_it_begins(given, position, yaw):
    pose = initial_pose(GRID, given)
    assert pose.position == pytest.approx(position, abs=1e-5)
    assert pose.heading == pytest.approx([math.cos(yaw), math.sin(yaw), 0])


def costs_of(*blocked):
    """Of GRID: lethal, unknown or too much within these boxes (x, y, x, y)."""
    x, y = GRID.vertices[:, 0], GRID.vertices[:, 1]
    costs = np.zeros(len(x), np.float32)
    for (left, low, right, high), cost in zip(blocked, itertools.cycle((np.inf, np.nan, 1.5))):
        costs[(left <= x) & (x <= right) & (low <= y) & (y <= high)] = cost
    return costs


@pytest.mark.parametrize(
    "blocked, expected",
    [
        # The middle is blocked, and there is more ground to the right of it.
        ([(4, 0, 5, 10)], (6, 4, 7, 6)),
        # To the right it would be nearer, but there is less ground.
        ([(3, 0, 5, 10), (5, 0, 10, 5)], (1, 4, 2, 6)),
        # The middle is free, but all around it is not.
        ([(0, 2, 10, 3), (0, 7, 10, 7), (3, 3, 3, 7), (7, 3, 7, 7)], (4, 8, 6, 9)),
    ],
)
def test_it_begins_on_the_largest_free_ground(blocked, expected):
    costs = costs_of(*blocked)
    pose = initial_pose(GRID, costs=costs)
    left, low, right, high = expected
    x, y, _ = pose.position
    assert left < x < right and low < y < high
    assert put_down(GRID, pose).position == pytest.approx(pose.position)
    # It stays where it is told to begin.
    assert initial_pose(GRID, (5, 5), costs).position == pytest.approx([5, 5, 0])


def test_it_begins_in_the_middle_where_nothing_is_free():
    costs = np.full(len(GRID.vertices), np.nan, np.float32)
    assert initial_pose(GRID, costs=costs).position == pytest.approx([5, 5, 0])


def test_of_two_storeys_it_begins_on_the_free_one():
    costs = np.where(STOREYS.vertices[:, 2] > 0.5, np.inf, 0).astype(np.float32)
    place = initial_pose(STOREYS, costs=costs).position
    assert place[2] < 0.5 < initial_pose(STOREYS).position[2]


@pytest.mark.parametrize("given", [(1,), (1, 2, 3, 4, 5), (1, "x"), (1, math.nan), ([1], [2, 3])])
def test_what_is_no_initial_pose_is_refused(given):
    with pytest.raises(MeshMapError, match="^initial_pose is .* m and rad"):
        initial_pose(GRID, given)


@pytest.mark.parametrize(
    "given, numbers",
    [("1 2 0.5", ["1", "2", "0.5"]), ("[1, 2]", ["1", "2"]), ([1, 2], [1, 2]), (7, [7])],
)
def test_lists_of_a_command_line(given, numbers):
    assert list(robot_messages.numbers_in(given)) == numbers


def test_defaults_are_within_their_limits():
    values, complaints = read_parameters(PARAMETERS, {p.name: p.default for p in PARAMETERS})
    assert complaints == []
    assert values == {p.name: p.default for p in PARAMETERS}
    assert all(parameter.description for parameter in PARAMETERS)


def test_messages_carry_what_they_are_made_from():
    command = Twist()
    command.linear.x, command.linear.y, command.angular.z = 1.0, 2.0, 3.0
    assert velocity_of(command) == Velocity(1.0, 2.0, 3.0)
    pose = Pose(np.array([1.0, 2.0, 3.0]), np.array([0.5, -0.5, 0.5, 0.5]))
    again = pose_from_message(bare_pose(pose))
    assert np.concatenate(again).tolist() == np.concatenate(pose).tolist()
    message = robot_messages.transform("map", "robot", pose, None)
    assert (message.header.frame_id, message.child_frame_id) == ("map", "robot")
    assert message.transform.translation.z == 3.0
    assert message.transform.rotation.y == -0.5
    message = robot_messages.odometry("odom", "robot", pose, Velocity(1.0, 2.0, 3.0), None)
    assert velocity_of(message.twist.twist) == Velocity(1.0, 2.0, 3.0)
    assert message.pose.pose.position.y == 2.0


@pytest.mark.parametrize(
    "given, map_frame",
    [
        ({"odom_frame": "base_footprint"}, ""),
        ({"odom_frame": "map"}, "map"),
        ({"base_frame": "/odom"}, ""),
        ({"sensor_frame": "base_footprint"}, ""),
        ({"base_frame": ""}, ""),
    ],
)
def test_frames_that_tf_cannot_connect_are_refused(given, map_frame):
    values, _ = read_parameters(PARAMETERS, given)
    with pytest.raises(MeshMapError, match=f"{list(given)[0]}.* different names"):
        check_frames(values, map_frame)


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"base_frame": "base_footprint"},
        {"sensor_frame": "base_link"},
        {"base_frame": "base", "footprint_frame": "base", "sensor_frame": "base"},
        {"odom_frame": "map", "localization": False},
    ],
)
def test_frames_that_tf_can_connect(given):
    check_frames(read_parameters(PARAMETERS, given)[0], "map")


def marker(kind, namespace="a", number=0, frame="map", action=Marker.ADD, size=2.0):
    made = Marker(type=kind, ns=namespace, id=number, action=action)
    made.header.frame_id = frame
    made.pose.position.x, made.pose.orientation.w = 4.0, 2.0
    made.scale.x = made.scale.y = made.scale.z = size
    return made


def test_markers_add_replace_and_delete_obstacles():
    markers = ObstacleMarkers([Obstacle.checked("box", Pose.at((0, 0, 0)), (1, 1, 1))])
    first = [marker(Marker.CYLINDER), marker(Marker.SPHERE, number=1), marker(Marker.CUBE, "b")]
    assert markers.change(MarkerArray(first), "map") == []
    assert [o.shape for o in markers.obstacles] == ["box", "cylinder", "sphere", "box"]
    assert markers.obstacles[1].pose.orientation.tolist() == [0, 0, 0, 1]
    markers.change(MarkerArray([marker(Marker.CUBE, size=3.0)]), "map")
    assert markers.obstacles[1].size.tolist() == [3, 3, 3]
    gone = [marker(0, number=1, action=Marker.DELETE), marker(0, "x", action=Marker.DELETE)]
    assert markers.change(MarkerArray(gone), "map") == []
    assert [o.shape for o in markers.obstacles] == ["box", "box", "box"]
    shown = markers.message("map", "base").markers
    assert shown[0].action == Marker.DELETEALL
    assert [(m.ns, m.id, m.type) for m in shown[1:]] == [
        ("obstacles", 0, Marker.CUBE),
        ("a", 0, Marker.CUBE),
        ("b", 0, Marker.CUBE),
        ("robot", 0, Marker.CUBE),
        ("robot", 1, Marker.ARROW),
    ]
    assert [m.header.frame_id for m in shown[1:]] == [*["map"] * 3, *["base"] * 2]
    # What was published comes back as the same obstacles.
    copy = ObstacleMarkers()
    copy.change(MarkerArray(shown[:-2]), "map")
    assert [o.size.tolist() for o in copy.obstacles] == [o.size.tolist() for o in markers.obstacles]
    markers.change(MarkerArray([marker(0, action=Marker.DELETEALL)]), "map")
    assert markers.obstacles == []


@pytest.mark.parametrize(
    "wrong, text",
    [
        (marker(Marker.ARROW), "its type is 0"),
        (marker(Marker.CUBE, frame="moon"), "its frame is 'moon'"),
        (marker(Marker.CUBE, size=0.0), "the size of a box is"),
        (marker(Marker.CUBE, size=math.nan), "the size of a box is"),
    ],
)
def test_markers_that_are_no_obstacles_are_named(wrong, text):
    markers = ObstacleMarkers()
    complaints = markers.change(MarkerArray([wrong, marker(Marker.CUBE, number=1)]), "map")
    assert len(complaints) == 1 and complaints[0].startswith("marker 'a' 0 is no obstacle: ")
    assert text in complaints[0]
    assert len(markers.obstacles) == 1


def test_simulations_need_no_ros_node():
    code = "import sys, mesh_navigation.simulation.{} as m; sys.exit('rospy' in sys.modules)"
    for module in ("driving", "robot_lidar", "robot_messages", "obstacle_messages", "placing"):
        subprocess.run([sys.executable, "-c", code.format(module)], check=True)
