"""Expressions of a case: parsed by a whitelist, evaluated with derivatives in compiled code."""
