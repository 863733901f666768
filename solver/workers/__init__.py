"""The preprocessor in its own Python: find, start, and distribute work over several processes."""
