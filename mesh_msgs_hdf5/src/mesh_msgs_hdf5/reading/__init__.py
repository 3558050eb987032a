"""Reads a part of an open map file, in whatever layout it has."""
