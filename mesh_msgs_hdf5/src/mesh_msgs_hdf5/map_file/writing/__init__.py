"""From a mesh, or an edit of one, to a map file in one step."""
