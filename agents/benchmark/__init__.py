"""The benchmark: every controller on the same held-out throws, with confidence intervals, resumable."""
