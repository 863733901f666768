"""A plan, its base motion, its models, and how two runs are compared."""
