"""Single throws by nonlinear programming, random goals and the virtual goal of Miyashita et al."""
