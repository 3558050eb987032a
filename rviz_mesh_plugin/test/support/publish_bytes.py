#!/usr/bin/python3
"""Publishes bytes as messages of a type, as nobody does who keeps to the format.

Usage: publish_bytes.py TOPIC PACKAGE/TYPE NODE_NAME. Once somebody has subscribed, each line of
standard input, in hexadecimal, is a message; the publisher goes when the input ends.
"""
import sys

import roslib.message
import rospy


def main():
    topic, type_name, node_name = sys.argv[1:]
    real = roslib.message.get_message_class(type_name)

    class Bytes(real):
        """A message whose bytes are given."""

        __slots__ = ["bytes"]
        _has_header = False  # nothing may be written into the bytes

        def __init__(self, data):
            self.bytes = data

        def serialize(self, buff):
            buff.write(self.bytes)

    rospy.init_node(node_name, disable_signals=True)
    publisher = rospy.Publisher(topic, Bytes, queue_size=None)
    while publisher.get_num_connections() == 0:
        rospy.sleep(0.01)
    for line in sys.stdin:
        publisher.publish(Bytes(bytes.fromhex(line)))


if __name__ == "__main__":
    main()
