"""Studies that run in a second or two."""

SMALL = """
name = "small"
question = "Which explores more?"
trials = {trials}

[compare]
axis = "destinations"
baseline = "quantile"

[scenario]
world = "lava-tube-small"
robots = 4
steps = 20

[axes]
destinations = ["quantile", "nearest"]
"""
