"""The process of the guard."""
