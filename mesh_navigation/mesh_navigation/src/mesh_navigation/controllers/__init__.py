"""Controllers that are part of this package."""
