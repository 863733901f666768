"""From a case file to what the other stages read."""
