"""What the documentation makes instead of saying: parts of pages from code, levels and results."""
