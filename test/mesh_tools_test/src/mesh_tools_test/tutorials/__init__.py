"""Tutorials of the site below docs/, done as they stand on their pages."""
