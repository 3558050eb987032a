"""Parts of the benchmark of the spatial index."""
