"""The robot of the demo: a simulated one, that goes where it is told."""
import rospy
from geometry_msgs.msg import PoseStamped
from mesh_navigation.base.messages import pose_from_message
from mesh_navigation.client.navigation_result import NavigationError
from nav_msgs.msg import Path

from mesh_tools_test.demo import navigation_node
from mesh_tools_test.demo.driven import Driven, Track, turn_between
from mesh_tools_test.demo.processes import DemoError, process, wait_until
from mesh_tools_test.demo.rviz_config import TRACK_TOPIC

FASTER = 5.0  # than real time
SCAN_RATE, SCAN_COLUMNS = 1.0, 120  # Hz of the simulation; rays around: few, time is fast
POSES = "/surface_robot/pose"  # where the robot is, whatever the server thinks
PATIENCE, SLOWEST = 60.0, 0.1  # seconds; m/s of the simulation


def simulate_time():
    """Let all nodes that are started from now on take the time from the simulator."""
    rospy.set_param("/use_sim_time", True)


def start_robot(output, start, goal):
    """The simulator, with the robot at the start [m], facing the goal; see processes.process."""
    place = [float(value) for value in start] + [navigation_node.heading(start, goal)]
    command = ["rosrun", "mesh_navigation", "surface_robot", "_publish_clock:=true"]
    command += [f"_real_time_factor:={FASTER}", f"_initial_pose:={place}"]
    command += [f"_scan_rate:={SCAN_RATE}", f"_scan_columns:={SCAN_COLUMNS}"]
    return process("surface_robot", command, output / "logs")


class Driver:
    """Lets the robot go, and publishes its track for RViz."""

    def __init__(self, navigator, robot):
        """
        :param navigator: a MeshNavigator
        :param robot: (name, process, log file) of the simulator, which must stay alive
        """
        self._navigator, self._robot = navigator, robot
        self._track, self._message, self._pose = Track(), Path(), None
        self._publisher = rospy.Publisher(TRACK_TOPIC, Path, latch=True, queue_size=1)
        rospy.Subscriber(POSES, PoseStamped, self._receive, queue_size=64)
        wait_until(lambda: self._pose is not None, 60, f"a message on {POSES}", [robot])

    def _receive(self, message):
        self._pose = pose_from_message(message.pose)
        if self._track.add(self._pose.position):
            self._message.header = message.header
            self._message.poses.append(message)

    def drive(self, goal, planner, planned):
        """Go to a goal.

        :param goal: PoseStamped
        :param planner: name
        :param planned: length of the path there [m]
        :returns: what became of it, a Driven
        """
        started = rospy.get_time()
        timeout = PATIENCE + planned / SLOWEST / FASTER
        try:
            result = self._navigator.go_to(goal, planner=planner, timeout=timeout)
        except NavigationError as error:
            raise DemoError(str(error)) from error
        seconds = rospy.get_time() - started
        wanted, reached = pose_from_message(goal.pose), self._pose
        self._publisher.publish(self._message)
        distance = float(((reached.position - wanted.position) ** 2).sum() ** 0.5)
        angle = turn_between(reached.heading, wanted.heading)
        track = self._track.positions
        succeeded, message = result.succeeded, result.message
        ends = (planned, track, seconds, distance, angle)
        return Driven(result.name, succeeded, message, *ends)
