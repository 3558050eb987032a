"""Processes of their own, forked by a small one. Imports nothing that takes time to load."""
