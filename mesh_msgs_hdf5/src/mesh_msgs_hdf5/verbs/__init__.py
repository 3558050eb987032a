"""Verbs of mesh_tool that other packages have: found, and run in a process of their own."""
