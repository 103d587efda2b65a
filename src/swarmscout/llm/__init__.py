"""Language models: providers, retries, budgets, cassettes, and a small one that needs no network.

This is the room that talks to networks, files and clocks. Robots' rooms know nothing of it: they
ask through :mod:`swarmscout.core.language_model`.
"""
