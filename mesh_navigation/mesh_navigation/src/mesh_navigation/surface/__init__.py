"""The map under a robot: where poses stand, what may be passed, and what that costs."""
