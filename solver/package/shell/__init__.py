"""The results file of a laminated shell."""
