"""The node hdf5_map_server."""
