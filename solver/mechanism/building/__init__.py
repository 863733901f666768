"""From the tables of a case to the readable tables of a mechanism."""
