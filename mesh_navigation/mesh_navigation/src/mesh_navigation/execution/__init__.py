"""Running one plan, drive or recovery behavior: patience, retries, and an answer in any case."""
