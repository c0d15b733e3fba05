"""What every room of `agents` stands on: command lines, files, environments by id, figures and tables."""
