"""Controllers, training and evaluation on `pnt_gym`: modules at the top are commands, folders hold their parts."""
