"""Policies as numbers: networks, and what is kept of a trained model."""
