"""Policies as arrays of numbers: networks, actors and scorers, without the libraries that trained them."""
