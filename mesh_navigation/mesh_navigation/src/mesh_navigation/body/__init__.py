"""The robot's body: its shape, and the ground that is closed for it."""
