"""Recording a mission into a run's folder, and reading it."""
