"""Recovery behaviors: what to try when there is no plan, or no way to follow it."""
