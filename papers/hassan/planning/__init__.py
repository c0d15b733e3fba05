"""Cycles from pick to pick that Hassan et al. 2022 compare, and the bound on free throws beside them."""
