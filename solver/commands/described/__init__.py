"""What the commands `section` and `shell` share: a results file for each description."""
