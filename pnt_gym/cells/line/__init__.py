"""Robots along one belt: who takes what next."""
