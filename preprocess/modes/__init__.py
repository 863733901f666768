"""Reduced basis of a body: eigenmodes under a reference condition, and static modes of loads."""
