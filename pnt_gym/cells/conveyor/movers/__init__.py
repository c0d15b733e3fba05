"""Movers, which plan the hand's motion: one file per mover, and a hand that rides with the belt around any mover."""
