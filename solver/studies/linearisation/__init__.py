"""Equations of motion linearised about a state: modes, Campbell diagrams, transfer functions."""
