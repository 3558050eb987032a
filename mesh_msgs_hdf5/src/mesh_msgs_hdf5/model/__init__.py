"""What a map holds: the mesh, changes of it, the schema, the names of labels, the one error."""
