"""The node of the simulated robot, with all that it publishes."""
