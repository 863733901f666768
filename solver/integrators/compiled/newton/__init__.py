"""Newton's matrix of implicit steps, and what forces add to it."""
