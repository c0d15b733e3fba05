"""What the documentation makes instead of saying: pages from code, levels and results."""
