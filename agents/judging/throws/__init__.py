"""Trials by throws: single throws that a controller corrects."""
