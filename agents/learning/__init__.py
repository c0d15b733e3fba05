"""Training: run folders, algorithms, and how a run is resumed."""
