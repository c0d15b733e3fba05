"""Throws whose release need not lie on a straight line from the pick."""
