"""Mapping: scans become evidence, evidence is exchanged, and summed up in occupancy grids."""
