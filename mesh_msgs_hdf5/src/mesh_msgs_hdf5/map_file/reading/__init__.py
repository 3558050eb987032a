"""From the groups of a map file to the members of a mesh."""
