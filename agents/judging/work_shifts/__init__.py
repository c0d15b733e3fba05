"""Trials by work shifts: a controller decides which object each robot of a line takes next."""
