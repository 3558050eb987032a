"""Driving in simulation, measured and checked: worlds, random trips, an oracle, statistics."""
