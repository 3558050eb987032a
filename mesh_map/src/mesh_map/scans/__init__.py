"""Point clouds of sensors with their poses: read from bags and files, and made in simulation."""
