"""Readers of mesh files, one per format: each returns the polygons of a file."""
