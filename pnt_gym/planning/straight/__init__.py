"""The release of a throw along a straight line from the pick (Hassan et al. 2022)."""
