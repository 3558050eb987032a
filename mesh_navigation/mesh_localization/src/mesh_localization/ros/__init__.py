"""The node mesh_localization."""
