"""Paths of several curves, and the quickest motion along each: what Choe et al. 2023 compare."""
