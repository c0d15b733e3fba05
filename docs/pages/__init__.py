"""Functions that make parts of pages from code, levels and results."""
