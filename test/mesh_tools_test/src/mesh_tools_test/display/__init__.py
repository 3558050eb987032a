"""The benchmark of RViz's display."""
