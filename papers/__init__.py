"""Four published systems, computed anew: one folder a paper, with the planning that only that paper needs."""
