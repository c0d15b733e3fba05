"""The one-joint thrower of Miyashita et al. 2010: an arm on one motor, and the references that move it."""
