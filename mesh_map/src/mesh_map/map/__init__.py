"""The map as its users see it: geometry, layers, attributes, and questions about places on it."""
