"""Missions: scenarios, the step, judging."""
