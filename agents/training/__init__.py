"""Trainings: what is asked for, the legs between checkpoints, and the table at the end."""
