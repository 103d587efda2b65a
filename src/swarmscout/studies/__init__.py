"""Studies: many missions compared, as declared in a study file."""
