"""Elements in UFL: lists of pairs (stress, strain), one file for each element."""
