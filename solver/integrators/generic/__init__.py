"""Integrators of y' = f(t, y) behind one contract; none of them knows a body."""
