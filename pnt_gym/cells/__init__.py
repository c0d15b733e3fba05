"""Cells: a robot in its surroundings, where a plan becomes an outcome."""
