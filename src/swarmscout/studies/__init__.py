"""Studies: many missions compared honestly, from a file that says what is asked."""
