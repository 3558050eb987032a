"""Parts of the benchmark of mesh maps: layers, changes, and the start of the node."""
