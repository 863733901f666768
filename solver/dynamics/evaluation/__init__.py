"""Evaluation of the equations of motion in one state, and in many."""
