"""A robot on a plane and its localizer, by a clock that the test may hold."""

import math
import threading
import time

import rospy
from driven_robot import is_zero, stamped_link
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from mesh_msgs.init_node import until_shutdown
from mesh_msgs.msg import LocalizationState

STEP = 0.05  # s
PAUSE = 0.025  # s, of the computer's time, from one step to the next: as long as a cycle may take


class SteppedRobot:
    """Obeys /cmd_vel; localized exactly, whatever its localizer says.

    Attributes:
        held: while it is set, time stands.
        says: what the localizer says again and again (state, reason); None: nothing.
    """

    def __init__(self, topic):
        self.x, self.y, self.yaw = 5.0, 5.0, 0.0
        self.held, self.says = False, None
        self._lock, self._now = threading.Lock(), 1000.0
        self._velocity, self._commands = Twist(), []
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self.state = rospy.Publisher(topic, LocalizationState, queue_size=10, latch=True)
        rospy.Subscriber("/cmd_vel", Twist, self._obey, queue_size=1000)
        threading.Thread(target=self._live, daemon=True).start()

    def say(self, state, reason=""):
        """What the localizer says from now on, at once even while time stands."""
        with self._lock:
            self.says = state, reason
            self._tell()

    def put(self, x, y, yaw=0.0):
        """Put it elsewhere."""
        with self._lock:
            self.x, self.y, self.yaw = x, y, yaw

    def forget(self):
        """Forget what it was told so far."""
        with self._lock:
            self._commands = []

    def moves(self):
        """The commands that were no zeros, since it was told to forget."""
        with self._lock:
            return [command for command in self._commands if not is_zero(command)]

    def told(self):
        """How many commands there were."""
        with self._lock:
            return len(self._commands)

    def steps(self, count):
        """Let time, which stands, go on by so many steps."""
        for _ in range(count):
            self._step()
            time.sleep(PAUSE)

    def _obey(self, message):
        with self._lock:
            self._velocity = message
            self._commands.append(message)

    def _live(self):
        with until_shutdown():
            while not rospy.is_shutdown():
                time.sleep(PAUSE)
                if not self.held:
                    self._step()

    def _step(self):
        with self._lock:
            self._now += STEP
            self.x += self._velocity.linear.x * math.cos(self.yaw) * STEP
            self.y += self._velocity.linear.x * math.sin(self.yaw) * STEP
            self.yaw += self._velocity.angular.z * STEP
            self._tf.publish(
                TFMessage([self._link("map", "odom"), self._link("odom", "base_link")])
            )
            if self.says:
                self._tell()
            self._clock.publish(Clock(rospy.Time.from_sec(self._now)))

    def _link(self, parent, child):
        message = stamped_link(parent, child, 0.0)
        message.header.stamp = rospy.Time.from_sec(self._now)
        if parent == "odom":
            translation, rotation = message.transform.translation, message.transform.rotation
            translation.x, translation.y = self.x, self.y
            rotation.z, rotation.w = math.sin(self.yaw / 2), math.cos(self.yaw / 2)
        return message

    def _tell(self):
        message = LocalizationState(state=self.says[0], reason=self.says[1])
        message.header.stamp, message.header.frame_id = rospy.Time.from_sec(self._now), "map"
        self.state.publish(message)
