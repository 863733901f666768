"""The commands `import` and `export`: bodies from and to other codes."""
