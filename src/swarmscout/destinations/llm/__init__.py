"""Destinations chosen by a language model: its prompts, and the reading of its answers."""
