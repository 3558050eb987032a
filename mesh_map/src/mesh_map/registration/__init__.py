"""Where a scan lies on a surface, and poses that agree with each other."""
