"""What all rooms stand on: poses and paths, clocks, cancels, outcomes, parameters, the robot."""
