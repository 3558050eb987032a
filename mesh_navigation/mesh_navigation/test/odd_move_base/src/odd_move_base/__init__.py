"""Plugins whose outcomes follow a list."""
