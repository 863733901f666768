"""The modal package of a shell."""
