"""Figures for print: the paper's kinds of picture, of any run."""
