"""Going to a goal: plans, drives and recovery behaviors one after the other, without ROS."""
