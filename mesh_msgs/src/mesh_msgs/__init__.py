"""Annotated triangle meshes in ROS: messages, arrays, validation."""
