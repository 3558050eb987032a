"""Layers of another package."""
