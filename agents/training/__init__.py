"""Trainings: their arguments, the legs between checkpoints, and the table at the end."""
