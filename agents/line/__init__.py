"""Tools of lines of robots: plan a line, tune controllers, train policies by imitation, count results of throws."""
