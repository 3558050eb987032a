"""PLY, ASCII and binary."""
