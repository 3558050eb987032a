"""Faults of all kinds while a robot drives: how soon it is told to stop, with real processes."""
