"""Robots along one belt: which object each robot takes next."""
