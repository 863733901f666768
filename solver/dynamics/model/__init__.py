"""The arrays of a mechanism: model, tables, coordinates, memory, structure of its equations."""
