"""Recovery behaviors that misbehave, for tests."""
