"""Dispatchers of lines: which robot takes which object next."""
