"""Point clouds and poses in files: read and written block by block, however large they are."""
