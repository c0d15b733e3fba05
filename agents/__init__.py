"""Training, evaluation and benchmarking of controllers on pnt_gym."""
