"""Parts of the benchmark of the planners, and of what they are made of."""
