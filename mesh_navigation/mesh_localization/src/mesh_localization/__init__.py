"""Where a robot is on a mesh: scans laid onto the map, and whether the answer can be trusted."""
