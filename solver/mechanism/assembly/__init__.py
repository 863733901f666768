"""From readable tables of a mechanism to the arrays of its model."""
