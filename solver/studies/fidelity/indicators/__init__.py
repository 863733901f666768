"""What a plan leaves out, and what that costs in each signal."""
