"""System tests, benchmarks and the demo of Mesh Tools."""
