"""The preprocessor in its own Python: find it, start it, distribute work over several processes."""
