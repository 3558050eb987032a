"""Planning and driving on mesh maps. Without ROS: planners. With ROS: a Move Base Flex server."""
