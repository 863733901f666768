"""Integration in time: generic methods for f(t, y), and compiled step loops of mechanisms."""
