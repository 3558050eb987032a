"""Verbs of mesh_tool (see mesh_msgs_hdf5.verbs.exported_verbs and verbs.xml)."""
