"""Derivatives of a run by parameters of its case: the motion, its start and its signals."""
