"""Linear systems with the structure of a mechanism, solved body by body."""
