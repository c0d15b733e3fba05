"""Evaluation of controllers: trials by throws or by work shifts, and their records."""
