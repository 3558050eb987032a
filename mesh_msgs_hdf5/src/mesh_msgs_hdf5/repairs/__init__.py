"""Meshes with other vertices and faces, everything that they have following."""
