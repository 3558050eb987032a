"""What the Move Base Flex server is made of, as far as that needs no rospy."""
