"""Studies that run in a second or two."""

import time

PATIENCE_S = 600.0
"""Longer than anything takes on a busy machine: only a test that fails waits for it."""

GATED = """
import time
from pathlib import Path
from swarmscout.destinations.selector import Choice

class Rule:
    '''Waits while as many missions have finished as the file "limit" says.'''

    def choose(self, view, memory):
        here = Path(__file__).parent
        while self.finished(here) >= int((here / "limit").read_text() or 0):
            time.sleep(0.01)
        return Choice(tuple(view.frontiers[0].tolist()))

    def finished(self, here):
        return len([p for p in (here / "out" / "missions").iterdir() if p.name[0] != "."])
"""


def until(condition, seconds=PATIENCE_S):
    """Wait for a condition, and return what it gave."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.02)
    return found


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
