"""Signals, processes, and what depends on the operating system."""
