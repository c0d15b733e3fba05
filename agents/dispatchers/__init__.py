"""Who decides on a line which robot takes which object next."""
