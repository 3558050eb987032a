"""Where rays meet a mesh, what is near a point, which faces lie in a region."""
