"""The one-joint thrower of Miyashita et al.: an arm on one motor, and the references that move it."""
