"""Who takes what next along a line: rules, planners and learners, how they are tuned, and what they are worth."""
