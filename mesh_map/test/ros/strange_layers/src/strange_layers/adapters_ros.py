"""How the layers get their data."""

import rospy
from geometry_msgs.msg import Point
from mesh_map.ros.ros_adapter import RosAdapter


class FlagAdapter(RosAdapter):
    """x: vertex, y: cost of a flag of 1 m."""

    def __init__(self, *args):
        super().__init__(*args)
        self._subscriber = rospy.Subscriber(self.namespace + "/flag", Point, self._move)

    def _move(self, message):
        self.layer.flag = int(message.x), message.y
        self.refresh()

    def shutdown(self):
        self._subscriber.unregister()


class Broken(RosAdapter):
    """Cannot be started."""

    def __init__(self, *args):
        raise OSError("no\nsensor")

    def shutdown(self):
        """Never comes to it."""
