"""What stands between the server and the base: a process of its own that passes velocities on."""
