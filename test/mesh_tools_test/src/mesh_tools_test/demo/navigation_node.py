"""The part of the demo that speaks ROS: ask the navigation server for plans."""
import threading
import time

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from mesh_map.costs.combination import COMBINED_COSTS
from mesh_msgs.arrays import MeshGeometryStamped, MeshVertexCostsStamped
from mesh_navigation import MeshNavigator
from mesh_navigation.client.navigation_result import NavigationError

from mesh_tools_test.demo.plans import POTENTIAL, Plan
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


def show_goal(start, goal, frame, topic):
    """Publish the goal for RViz, the pose that the planners are asked for."""
    latch(topic, pose(goal, frame, heading(start, goal)))


class PlanClient:
    """Asks `get_path` for plans, as any client of Move Base Flex does.

    When it is made, the layers of the map are there.
    """

    def __init__(self, server, timeout=120.0):
        """
        :param server: (name, process, log file), which must stay alive meanwhile
        :param timeout: for the server to appear, for the layers, for a plan, and its potential [s]
        """
        start_node()
        self._server, self._timeout = server, timeout
        self._costs, self._changed = {}, threading.Lock()
        rospy.Subscriber(
            f"{SERVER}/mesh_map/vertex_costs", MeshVertexCostsStamped, self._receive, queue_size=64
        )
        self.navigator = MeshNavigator(SERVER)
        self._wait_for(COMBINED_COSTS)  # the last layer

    def _receive(self, message):
        with self._changed:
            self._costs[message.type] = message.mesh_vertex_costs.costs

    def _wait_for(self, layer):
        """The costs (V,) of a layer, when they have come."""
        what = f"a message of '{layer}' on {SERVER}/mesh_map/vertex_costs"
        wait_until(lambda: layer in self._costs, self._timeout, what, [self._server])
        return self._costs[layer]

    def plan(self, start, goal, frame, planner):
        """A plan from start to goal [m]; both poses head along the straight way between them.

        :returns: the Plan, when the server has published its potential
        :raises DemoError: with the server's outcome and message when there is no path
        """
        yaw = heading(start, goal)
        ends = {"start": pose(start, frame, yaw), "timeout": self._timeout}
        with self._changed:
            self._costs.pop(POTENTIAL, None)
        started = time.monotonic()
        try:
            answer = self.navigator.get_path(pose(goal, frame, yaw), planner=planner, **ends)
        except NavigationError as error:
            raise DemoError(str(error)) from error
        seconds = time.monotonic() - started
        if not answer.succeeded:
            raise DemoError(f"no path of {planner}, outcome {answer}")
        result = answer.details
        positions = [stamped.pose.position for stamped in result.path.poses]
        points = np.array([(point.x, point.y, point.z) for point in positions])
        potential = self._wait_for(POTENTIAL)
        return Plan(points, result.cost, result.message, seconds, potential)
