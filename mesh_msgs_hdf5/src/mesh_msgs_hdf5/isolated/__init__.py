"""Processes of their own, in which hostile files are read."""
