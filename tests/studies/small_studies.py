"""Studies that run in a second or two, and what runs them in this process."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

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


class InThisProcess:
    """An engine of one thread: quick, and enough where nobody is killed."""

    width = 1

    @contextmanager
    def open(self):
        with ThreadPoolExecutor(1) as pool:
            yield pool
