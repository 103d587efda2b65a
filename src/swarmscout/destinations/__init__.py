"""Destinations: when a team needs a new one, and the rules that choose it."""
