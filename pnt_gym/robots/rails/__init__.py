"""A hand on three rails: the stand-in of robots that are known by their data sheets alone."""
