"""A recorder of your own sees each step of a mission while it runs."""

import numpy as np

import swarmscout as ss

STEPS = 150


class LongestDrives:
    """Counts the steps in which each robot moved."""

    def begin(self, mission):
        self.moved = np.zeros(mission.scenario.robots, dtype=int)
        self.last = mission.bodies.pose[:, :2].copy()

    def record(self, record):
        now = record.pose[:, :2]
        self.moved += np.hypot(*(now - self.last).T) > 0.01
        self.last = now.copy()  # The mission reuses its arrays.

    def end(self, summary):
        print(f"moved in {self.moved.min()} to {self.moved.max()} of {summary['steps']} steps")


scenario = ss.load_scenario("default", {"robots": 8, "steps": STEPS})
ss.record_mission(scenario, record="summary", watchers=[LongestDrives()])
