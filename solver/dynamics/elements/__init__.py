"""What a mechanism is made of: bodies, joints, couplings, forces, treatments of constraints."""
