"""Four published systems, computed anew: a folder for each paper, with the planning code that only this paper needs."""
