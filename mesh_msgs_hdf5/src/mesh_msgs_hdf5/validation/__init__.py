"""What is wrong or odd about a mesh file."""
