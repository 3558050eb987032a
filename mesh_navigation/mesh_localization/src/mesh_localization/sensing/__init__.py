"""What sensors measure, as rays in the frame of the robot; nothing of rospy: messages are data."""
