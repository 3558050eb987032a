"""Errors and warnings of the sources, held against the pages that explain them."""
