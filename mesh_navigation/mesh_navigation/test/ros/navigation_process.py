"""A whole navigation server in a process of its own, with a simulated robot, and bare topics."""

import os
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import rospy
from actionlib_msgs.msg import GoalID
from geometry_msgs.msg import Twist
from mbf_msgs import msg
from server_process import TESTS, program, stamped

from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected

ACTIONS = {"get_path": "GetPath", "exe_path": "ExePath", "recovery": "Recovery"}
ACTIONS["move_base"] = "MoveBase"


class NodeProcess:
    """A node of the package; ``stop`` ends it."""

    def __init__(self, name, executable, package="mesh_navigation", **parameters):
        self.name = name
        for key, value in {"shutdown_timeout": 60.0, **parameters}.items():
            rospy.set_param(f"/{name}/{key}", value)
        environment = dict(os.environ)
        odd = TESTS / "odd_planners"
        environment["ROS_PACKAGE_PATH"] = f"{odd}:{environment['ROS_PACKAGE_PATH']}"
        environment["PYTHONPATH"] = f"{odd / 'src'}:{environment['PYTHONPATH']}"
        self.log = tempfile.NamedTemporaryFile("r", prefix=name, suffix=".log")
        with open(self.log.name, "w") as log:
            self.process = subprocess.Popen(
                [program(package, executable), f"__name:={name}"],
                env=environment,
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    def output(self):
        """What the process has printed."""
        return Path(self.log.name).read_text()

    def end(self, by=signal.SIGTERM):
        """End the process by a signal; returns its exit status and the seconds it took."""
        begin = time.monotonic()
        self.process.send_signal(by)
        return self.process.wait(60), time.monotonic() - begin

    def kill(self):
        """End the process if it is still there, for tests that failed half-way."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait(30)


class ActionTopics:
    """The bare topics of one action; results and states by the goal's id."""

    def __init__(self, node, action, process=None):
        """Waits for the server; ``process`` is it, if its output may say why it does not come."""
        kind = ACTIONS[action]
        topic = f"/{node}/{action}"
        self.results = {}
        self._goal_type = getattr(msg, f"{kind}Goal")
        self._message_type = getattr(msg, f"{kind}ActionGoal")
        result_type = getattr(msg, f"{kind}ActionResult")
        self._goal = rospy.Publisher(f"{topic}/goal", self._message_type, queue_size=1000)
        self._cancel = rospy.Publisher(f"{topic}/cancel", GoalID, queue_size=1000)
        self._result = rospy.Subscriber(f"{topic}/result", result_type, self._note)
        self._ends = (self._goal, self._cancel, self._result)
        try:
            wait_until(self.connected, f"connections to {topic}")
        except AssertionError as error:
            raise AssertionError(f"{error}: {process.output() if process else ''}") from error

    def connected(self):
        """Whether the server is there."""
        return connected(*self._ends)

    def send(self, key, **fields):
        """Send a goal of that id; returns the id."""
        goal = self._goal_type(**fields)
        self._goal.publish(self._message_type(goal_id=GoalID(id=key), goal=goal))
        return key

    def cancel(self, key):
        """Cancel the goal of that id."""
        self._cancel.publish(GoalID(id=key))

    def answer(self, key):
        """(state, result) of a goal, once it is done."""
        wait_until(lambda: self.results.get(key), f"an answer to {key}")
        message = self.results[key][0]
        return message.status.status, message.result

    def close(self):
        """Leave the topics."""
        for end in self._ends:
            end.unregister()

    def _note(self, message):
        self.results.setdefault(message.status.goal_id.id, []).append(message)


class Velocities:
    """What is commanded on /cmd_vel."""

    def __init__(self):
        self.last, self.moves = None, 0
        self._subscriber = rospy.Subscriber("/cmd_vel", Twist, self._note)

    def _note(self, message):
        self.last = message.linear.x, message.linear.y, message.angular.z
        self.moves += self.moving

    def forget(self):
        """As if there had been none."""
        self.last, self.moves = None, 0

    @property
    def moving(self):
        """Whether the robot is told to move."""
        return self.last is not None and any(self.last)

    @property
    def stopped(self):
        """Whether the last command was to stand."""
        return self.last is not None and not any(self.last)

    def close(self):
        """Listen no more."""
        self._subscriber.unregister()


def upright(x, y, z=0.0):
    """A pose in the map's frame."""
    return stamped((x, y, z))
