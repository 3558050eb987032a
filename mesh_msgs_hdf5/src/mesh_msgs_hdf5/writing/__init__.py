"""Builds map files, verifies them and puts them in their place."""
