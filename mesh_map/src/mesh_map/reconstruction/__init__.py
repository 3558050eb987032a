"""A surface made of registered scans, by a truncated signed distance in hashed voxel blocks."""
