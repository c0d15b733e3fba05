"""Trials by work shifts: lines on which a controller decides what comes next."""
