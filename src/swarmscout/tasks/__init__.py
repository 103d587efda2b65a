"""Tasks: which cells of a map are worth heading for, and when the mission is done."""
