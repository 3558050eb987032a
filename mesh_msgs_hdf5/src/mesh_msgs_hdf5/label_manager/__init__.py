"""The node label_manager: labels without a map, and those of its release 1.x."""
