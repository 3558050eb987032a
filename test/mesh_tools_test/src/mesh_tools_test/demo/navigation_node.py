"""The part of the demo that speaks ROS: ask the navigation server for a plan."""
import actionlib
import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped, TransformStamped
from mbf_msgs.msg import GetPathAction, GetPathGoal, GetPathResult
from mesh_msgs.arrays import MeshGeometryStamped
from tf2_msgs.msg import TFMessage

from mesh_tools_test.demo.processes import DemoError, wait_until

SERVER = "/move_base_flex"
_latched = []  # rospy ends a topic when its publisher is garbage


def heading(start, goal):
    """Yaw [rad] of the straight way from start to goal; 0 where one lies above the other."""
    return float(np.arctan2(goal[1] - start[1], goal[0] - start[0]))


def pose(point, frame, yaw=0.0):
    """An upright pose at a point [m] with a heading [rad]."""
    stamped = PoseStamped()
    stamped.header.frame_id = frame
    stamped.header.stamp = rospy.Time.now()
    position = stamped.pose.position
    position.x, position.y, position.z = map(float, point)
    stamped.pose.orientation.z = float(np.sin(yaw / 2))
    stamped.pose.orientation.w = float(np.cos(yaw / 2))
    return stamped


def start_node():
    """Make this process a ROS node, if it is none yet."""
    if not rospy.core.is_initialized():
        rospy.init_node("mesh_tools_demo", anonymous=True, disable_signals=True)


def wait_for_map(server, timeout=120.0):
    """Wait until the server publishes its mesh; returns the mesh's UUID.

    :param server: (name, process, log file), which must stay alive meanwhile
    """
    start_node()
    received = []
    topic = f"{SERVER}/mesh_map/mesh"
    subscriber = rospy.Subscriber(topic, MeshGeometryStamped, received.append)
    try:
        wait_until(lambda: received, timeout, f"a mesh on {topic}", [server])
    finally:
        subscriber.unregister()
    return received[0].uuid


def latch(topic, message):
    """Publish one message for everybody who comes until this process ends."""
    publisher = rospy.Publisher(topic, type(message), latch=True, queue_size=1)
    publisher.publish(message)
    _latched.append(publisher)


def place_robot(start, goal, frame, robot_frame):
    """Say in TF that the robot stands upright at the start [m], facing the goal."""
    stamped = pose(start, frame, heading(start, goal))
    transform = TransformStamped()
    transform.header, transform.child_frame_id = stamped.header, robot_frame
    translation = transform.transform.translation
    translation.x, translation.y, translation.z = map(float, start)
    transform.transform.rotation = stamped.pose.orientation
    latch("/tf_static", TFMessage(transforms=[transform]))


def show_goal(start, goal, frame, topic):
    """Publish the goal for RViz, the pose that plan() asks for."""
    latch(topic, pose(goal, frame, heading(start, goal)))


def plan(start, goal, frame, planner, timeout=60.0):
    """Ask `get_path` for a plan, as any client of Move Base Flex does.

    Both poses head along the straight way from start to goal.

    :returns: the GetPathResult and the path's positions (N,3) [m]
    :raises DemoError: with the server's outcome and message when there is no path
    """
    start_node()
    client = actionlib.SimpleActionClient(f"{SERVER}/get_path", GetPathAction)
    if not client.wait_for_server(rospy.Duration(timeout)):
        raise DemoError(f"no action server at {SERVER}/get_path within {timeout:.0f} s")
    yaw = heading(start, goal)
    request = GetPathGoal(use_start_pose=True, planner=planner)
    request.start_pose, request.target_pose = pose(start, frame, yaw), pose(goal, frame, yaw)
    client.send_goal(request)
    if not client.wait_for_result(rospy.Duration(timeout)):
        client.cancel_goal()
        raise DemoError(f"no plan within {timeout:.0f} s")
    result = client.get_result()
    if result.outcome != GetPathResult.SUCCESS:
        raise DemoError(f"no path, outcome {result.outcome}: {result.message}")
    positions = [stamped.pose.position for stamped in result.path.poses]
    return result, np.array([(point.x, point.y, point.z) for point in positions])
