"""Where to put a suction cup: features of pictures, rules, networks, and the tries from which they learn."""
