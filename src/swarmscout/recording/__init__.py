"""A run's folder: what a mission did, written while it runs, and the one reader of it."""
