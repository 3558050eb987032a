"""What several benchmarks share: worlds, figures, the programs and servers that are measured."""
