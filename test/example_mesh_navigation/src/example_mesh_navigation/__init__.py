"""A planner and a controller for mesh_navigation in a package of their own."""
