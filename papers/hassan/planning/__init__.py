"""Cycles from pick to pick that Hassan et al. 2022 compare, and the quickest throw in a free direction."""
