"""The parts of the node that know nothing of rospy."""
