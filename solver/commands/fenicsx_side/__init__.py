"""The preprocessor in its own Python: finding it, starting it, sharing work among several."""
