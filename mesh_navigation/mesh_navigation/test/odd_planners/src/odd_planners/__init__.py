"""Planners that misbehave, for tests."""
