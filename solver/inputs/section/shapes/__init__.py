"""The library of parametric sections."""
