"""The site below docs/: its tutorials, which are run, and its reference, which is made of the code."""
