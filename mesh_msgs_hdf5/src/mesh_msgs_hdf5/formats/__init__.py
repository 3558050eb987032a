"""Meshes of other programs, read and written."""
