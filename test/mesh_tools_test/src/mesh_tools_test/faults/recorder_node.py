"""A process that does nothing but note when commands and poses of the robot come."""

import sys
import threading
import time

import rospy
from geometry_msgs.msg import PoseStamped, Twist


def main() -> None:
    """Appends to the file that is named, one line each, until the node is shut down."""
    lock = threading.Lock()
    with open(sys.argv[1], "a", encoding="ascii", buffering=1) as file:

        def write(kind: str, *values: float) -> None:
            now = time.monotonic()
            with lock:
                file.write("%s %r %s\n" % (kind, now, " ".join(map(repr, values))))

        def on_command(message: Twist) -> None:
            linear, angular = message.linear, message.angular
            write("command", max(map(abs, (linear.x, linear.y, angular.z))))

        def on_pose(message: PoseStamped) -> None:
            write("pose", message.pose.position.x, message.pose.position.y)

        rospy.init_node("recorder")
        for topic, kind, handle in (
            ("/cmd_vel", Twist, on_command),
            ("/surface_robot/pose", PoseStamped, on_pose),
        ):
            rospy.Subscriber(topic, kind, handle, queue_size=1000, tcp_nodelay=True)
        rospy.spin()


if __name__ == "__main__":
    main()
