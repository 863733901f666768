"""The model of a run chosen by the accuracy that the user asks for, and checked."""
