"""A robot followed from scan to scan; nothing of ROS."""
