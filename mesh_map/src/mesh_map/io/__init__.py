"""Maps from files, their parameters, and messages of them; without rospy."""
