"""A navigation server in a process of its own, and a client to talk to it."""

import functools
import os
import signal
import subprocess
import tempfile
from pathlib import Path
from xmlrpc.client import ServerProxy

import actionlib
import numpy as np
import rosgraph
import roslib.packages
import rospy
from actionlib_msgs.msg import GoalID, GoalStatusArray
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import GetPathAction, GetPathActionGoal, GetPathActionResult, GetPathGoal

from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

TESTS = Path(__file__).resolve().parents[1]
STATES = ["PENDING", "ACTIVE", "PREEMPTED", "SUCCEEDED", "ABORTED", "REJECTED"]
STATES += ["PREEMPTING", "RECALLING", "RECALLED", "LOST"]
TIMEOUT = rospy.Duration(60)


def write_map(mesh, folder=None):
    """A map file of the mesh; returns its path."""
    path = Path(folder or tempfile.mkdtemp(prefix="mesh_navigation_")) / "map.h5"
    MapFile.write(str(path), Mesh(vertices=mesh.vertices, faces=mesh.faces))
    return str(path)


@functools.lru_cache(maxsize=None)
def program(package, name):
    """What `rosrun package name` becomes, without its searches at each start."""
    return roslib.packages.find_node(package, name)[0]


class ServerProcess:
    """The server under a name of its own, with parameters; ``stop`` ends it.

    With ``wait`` False others can be started meanwhile; ``client`` is there after
    ``wait_for_server``. ``remappings`` are arguments such as a:=b. Parameters that are None are
    not set.
    """

    def __init__(self, name, package="mesh_navigation", wait=True, remappings=(), **parameters):
        self.name = name
        for key, value in {"shutdown_timeout": TIMEOUT.to_sec(), **parameters}.items():
            if value is not None:
                rospy.set_param(f"/{name}/{key}", value)
        environment = dict(os.environ)
        for odd in TESTS.glob("odd_*"):
            environment["ROS_PACKAGE_PATH"] = f"{odd}:{environment['ROS_PACKAGE_PATH']}"
            environment["PYTHONPATH"] = f"{odd / 'src'}:{environment['PYTHONPATH']}"
        self.log = tempfile.NamedTemporaryFile("r", prefix=name, suffix=".log")
        with open(self.log.name, "w") as log:
            self._process = subprocess.Popen(
                [program(package, "mbf_mesh_nav"), f"__name:={name}", *remappings],
                env=environment,
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        # Storms: of a burst of more than 10, clients would drop the oldest goals unsent.
        rospy.set_param("/actionlib_client_pub_queue_size", 1000)
        self.client = None
        if wait:
            self.wait_for_server()

    def wait_for_server(self):
        """Until it takes goals; returns self."""
        self.client = actionlib.ActionClient(f"/{self.name}/get_path", GetPathAction)
        if not self.client.wait_for_server(TIMEOUT):
            raise RuntimeError(f"no server: {self.output()}")
        return self

    def output(self):
        """What the process has printed."""
        self.log.seek(0)
        return self.log.read()

    def terminate(self, by=signal.SIGTERM):
        """Tell the process to end."""
        self._process.send_signal(by)

    def wait(self):
        """Wait for its end; returns its exit status."""
        return self._process.wait(90)

    def stop(self):
        """End the process politely; returns its exit status."""
        self.terminate()
        return self.wait()

    def kill(self):
        """End the process if it is still there, for tests that failed half-way."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait(90)

    def send(self, start=None, goal=(8.1, 8.1, 0.0), **fields):
        """Send a goal; start None is the robot's pose. Positions or whole PoseStamped messages."""
        message = GetPathGoal(target_pose=stamped(goal), **fields)
        if start is not None:
            message.use_start_pose, message.start_pose = True, stamped(start)
        return self.client.send_goal(message)

    def ask(self, *args, **fields):
        """Send a goal and wait for the answer: (state, result)."""
        return answer(self.send(*args, **fields))


class Topics:
    """The bare topics of an action; results by the goal's id.

    actionlib's client loses a goal that it cancels before the acknowledgement, or after the end.
    """

    def __init__(self, action):
        self.results = {}
        self.goal = rospy.Publisher(f"{action}/goal", GetPathActionGoal, queue_size=10)
        self.cancel = rospy.Publisher(f"{action}/cancel", GoalID, queue_size=10)
        self._subscriber = rospy.Subscriber(f"{action}/result", GetPathActionResult, self._note)
        self.seen = set()
        status = rospy.Subscriber(f"{action}/status", GoalStatusArray, self._note_status)
        ends = (self.goal, self.cancel, self._subscriber, status)
        wait_until(lambda: connected(*ends), "connections")

    def _note(self, message):
        self.results[message.status.goal_id.id] = message

    def _note_status(self, message):
        self.seen |= {status.goal_id.id for status in message.status_list}


def stamped(pose, frame="map"):
    if isinstance(pose, PoseStamped):
        return pose
    message = PoseStamped()
    message.header.frame_id = frame
    position = message.pose.position
    position.x, position.y, position.z = (float(value) for value in pose)
    message.pose.orientation.w = 1.0
    return message


def answer(handle):
    """(state, result) of a goal, once it is done."""
    done = actionlib.CommState.DONE
    wait_until(lambda: handle.get_comm_state() == done, "an answer")
    return STATES[handle.get_terminal_state()], handle.get_result()


def positions(path):
    return np.array([[p.pose.position.x, p.pose.position.y, p.pose.position.z] for p in path.poses])


def pid_of(node):
    """None where there is no such node, or it does not answer."""
    try:
        return ServerProxy(rosgraph.Master("/test").lookupNode(node)).getPid("/test")[2]
    except (OSError, rosgraph.MasterError):
        return None


def published_topics():
    """Names of all topics with a publisher."""
    return {name for name, _ in rosgraph.Master("/test").getPublishedTopics("")}
