"""A program on a virtual screen, and the hands of its user."""
