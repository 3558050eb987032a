"""Mesh files of other programs: a reader (import_*) and a writer (export_*) for each format."""
