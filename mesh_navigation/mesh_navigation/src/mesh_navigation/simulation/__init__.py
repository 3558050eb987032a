"""Robots that exist only here: to try maps, planners and controllers without one."""
