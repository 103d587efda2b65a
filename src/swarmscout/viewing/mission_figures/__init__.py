"""Figures of a mission for print, in the style of the paper's."""
