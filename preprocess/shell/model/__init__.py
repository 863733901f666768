"""A shell as a finite-element model: lay-ups, supports, links, loads, matrices."""
