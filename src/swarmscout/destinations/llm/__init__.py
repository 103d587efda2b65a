"""Destinations chosen by a language model: what it is told, and what counts as its answer."""
