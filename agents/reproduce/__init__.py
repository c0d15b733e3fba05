"""The door to `papers/`: the papers' parts as jobs, and what they find as one record and its tables."""
