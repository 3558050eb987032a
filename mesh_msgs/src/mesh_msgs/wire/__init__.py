"""Messages as arrays laid over their bytes: framing, members, classes."""
