"""The choice of a plan from its indicators, and the file of a plan."""
