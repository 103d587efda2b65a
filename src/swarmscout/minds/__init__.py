"""Minds: what each robot believes, as arrays, and the views that policies get."""
