"""Datasets of throws and decisions."""
