"""Tools of lines of robots: plan a line, tune controllers, count results of throws."""
