"""Access to `papers/`: the parts of papers as jobs, and their findings as one record and its tables."""
