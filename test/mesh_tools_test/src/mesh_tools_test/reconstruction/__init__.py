"""Parts of the benchmark of reconstruction: surfaces of scans, their poses, maps of bags."""
