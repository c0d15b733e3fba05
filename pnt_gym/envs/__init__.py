"""Gymnasium facades over the cells."""
