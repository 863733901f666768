"""Laminated shells: description, load cases, results on the screen and as figures."""
