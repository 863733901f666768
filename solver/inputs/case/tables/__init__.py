"""The tables of a case file: every key with type, unit, bounds and one line of meaning."""
