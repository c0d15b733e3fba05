"""Paths of several curves and the quickest motion along each path, which Choe et al. 2023 compare."""
