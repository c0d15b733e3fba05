"""Throws in a free direction: the release need not lie on a straight line from the pick."""
