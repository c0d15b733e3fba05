"""Whole cycles of pick and throw, and how their motions blend."""
