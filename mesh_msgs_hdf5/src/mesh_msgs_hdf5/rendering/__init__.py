"""Pictures of meshes without a screen."""
