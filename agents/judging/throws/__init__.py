"""Trials by throws: a controller corrects single throws."""
