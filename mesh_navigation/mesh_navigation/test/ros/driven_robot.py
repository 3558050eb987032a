"""A robot that obeys /cmd_vel and is seen in TF, as far as the test wants; and its client."""

import math
import threading
import time

import actionlib
import rospy
from actionlib_msgs.msg import GoalID
from geometry_msgs.msg import PoseStamped, TransformStamped, Twist
from mbf_msgs.msg import ExePathAction, ExePathActionGoal, ExePathActionResult, ExePathGoal
from nav_msgs.msg import Path
from server_process import STATES, TIMEOUT
from tf2_msgs.msg import TFMessage

from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import connected


class DrivenRobot:
    """Drives in the plane by the computer's time; knows all commands it got."""

    def __init__(self):
        self.lock = threading.Lock()
        self.x = self.y = self.yaw = 0.0
        self.velocity, self.commands = Twist(), []
        self.obeys = self.seen = True
        self.behind = 0.0  # s that TF is too old
        self.localized = None  # s that a localizer's link of its own, map to odom, is old
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        rospy.Subscriber("/cmd_vel", Twist, self._obey, queue_size=1000)
        self._time = time.monotonic()
        threading.Thread(target=self._live, daemon=True).start()

    def _obey(self, message):
        with self.lock:
            self.velocity = message
            self.commands.append(message)

    def _live(self):
        while not rospy.is_shutdown():
            time.sleep(0.02)
            with self.lock:
                now = time.monotonic()
                elapsed, self._time = now - self._time, now
                if self.obeys:
                    self.x += self.velocity.linear.x * math.cos(self.yaw) * elapsed
                    self.y += self.velocity.linear.x * math.sin(self.yaw) * elapsed
                    self.yaw += self.velocity.angular.z * elapsed
                if self.seen:
                    parent = "map" if self.localized is None else "odom"
                    self._tf.publish(TFMessage([self._transform(parent)]))
                if self.localized is not None:
                    link = stamped_link("map", "odom", self.localized)
                    self._tf.publish(TFMessage([link]))

    def _transform(self, parent):
        message = stamped_link(parent, "base_link", self.behind)
        translation, rotation = message.transform.translation, message.transform.rotation
        translation.x, translation.y = self.x, self.y
        rotation.z, rotation.w = math.sin(self.yaw / 2), math.cos(self.yaw / 2)
        return message

    def put(self, x=0.0, y=0.0, yaw=0.0):
        """Put it elsewhere; forget its commands."""
        with self.lock:
            self.x, self.y, self.yaw = x, y, yaw
            self.commands.clear()

    def stands(self):
        """Whether the last command, if there was any, was zero."""
        with self.lock:
            return not self.commands or is_zero(self.commands[-1])


class ExePathClient:
    """Sends paths."""

    def __init__(self, name):
        self.client = actionlib.ActionClient(f"/{name}/exe_path", ExePathAction)
        assert self.client.wait_for_server(TIMEOUT), f"no {name}/exe_path"

    def send(self, goal=(3.0, 0.0), controller="", feedback=None, **fields):
        """Send a path (a message, or the goal's x and y)."""
        path = goal if isinstance(goal, Path) else path_to(*goal)
        message = ExePathGoal(path=path, controller=controller, **fields)
        listener = feedback and (lambda _, received: feedback(received))
        return self.client.send_goal(message, feedback_cb=listener)

    def ask(self, *args, **fields):
        """Send a path and wait for the answer: (state, result)."""
        return self.answer(self.send(*args, **fields))

    @staticmethod
    def answer(handle):
        """(state, result), once it is done."""
        done = actionlib.CommState.DONE
        wait_until(lambda: handle.get_comm_state() == done, "an answer")
        return STATES[handle.get_terminal_state()], handle.get_result()


class BareClient:
    """The topics of the action alone.

    actionlib's client loses a goal that it cancels before the acknowledgement, or after the end.
    """

    def __init__(self, name):
        action = f"/{name}/exe_path"
        self.results, self.twice = {}, []
        self._goal = rospy.Publisher(f"{action}/goal", ExePathActionGoal, queue_size=1000)
        self._cancel = rospy.Publisher(f"{action}/cancel", GoalID, queue_size=1000)
        result = rospy.Subscriber(f"{action}/result", ExePathActionResult, self._note)
        ends = (self._goal, self._cancel, result)
        wait_until(lambda: connected(*ends), "connections")

    def _note(self, message):
        key = message.status.goal_id.id
        self.twice += [key] if key in self.results else []
        self.results[key] = message

    def send(self, key, goal=(3.0, 0.0), controller=""):
        """Send a goal with an id."""
        message = ExePathActionGoal(goal_id=GoalID(id=key))
        message.goal.path, message.goal.controller = path_to(*goal), controller
        self._goal.publish(message)

    def cancel(self, key):
        """Cancel the goal of that id."""
        self._cancel.publish(GoalID(id=key))

    def answer(self, key):
        """(state, result), once it is done."""
        wait_until(lambda: key in self.results, f"an answer to {key}")
        return STATES[self.results[key].status.status], self.results[key].result


def stamped_link(parent, child, age):
    """A transform that changes nothing, so many seconds old."""
    message = TransformStamped()
    message.header.stamp = rospy.Time.from_sec(rospy.get_time() - age)
    message.header.frame_id, message.child_frame_id = parent, child
    message.transform.rotation.w = 1.0
    return message


def path_to(x, y, frame="map", count=3):
    """A straight path from the origin."""
    path = Path()
    path.header.frame_id = frame
    for index in range(count):
        pose = PoseStamped()
        pose.header.frame_id = frame
        pose.pose.position.x = x * (index + 1) / count
        pose.pose.position.y = y * (index + 1) / count
        pose.pose.orientation.w = 1.0
        path.poses.append(pose)
    return path


def is_zero(twist):
    linear, angular = twist.linear, twist.angular
    return not any([linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])
