"""Basics of all of `agents`: command lines, files, environments by id, figures and tables."""
