"""Language models: providers, retries, budgets, cassettes, and a small embedded model.

This package alone uses networks and clocks for language models. Robots know nothing of it: their
selectors ask through :mod:`swarmscout.core.language_model`.
"""
