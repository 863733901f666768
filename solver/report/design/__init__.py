"""Studies of a design as a page, and as sections of the report of a case."""
