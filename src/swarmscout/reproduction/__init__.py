"""The paper, reproduced: each of its figures from our own runs, beside the paper's claim.

The paper is H. Kawashima et al., "LLM-Guided Decentralized Exploration with Self-Organizing Robot
Teams", AROB-ISBC 2026. Every number and picture comes from a mission.
"""
