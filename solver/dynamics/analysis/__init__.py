"""What follows from the equations in one state: rank, scales, reactions, projection."""
