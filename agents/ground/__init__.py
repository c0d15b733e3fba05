"""Basics of all of `agents`: command lines, files, environments, figures, tables, work in processes and on clusters."""
