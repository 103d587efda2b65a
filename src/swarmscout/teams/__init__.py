"""Team formation: desired sizes, and who leaves, joins and leads."""
