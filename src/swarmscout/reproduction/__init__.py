"""The paper, reproduced: each of its figures from our own runs, beside what it claims.

The paper is H. Kawashima et al., "LLM-Guided Decentralized Exploration with Self-Organizing Robot
Teams", AROB-ISBC 2026. Every number and picture is read from a mission; none is typed in.
"""
