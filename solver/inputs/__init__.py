"""What a user writes, read and checked: cases, cross-sections, shells."""
