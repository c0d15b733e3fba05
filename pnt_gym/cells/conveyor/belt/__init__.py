"""The belt: the stream of objects, the choice of the next pick, and collisions of a carried object with others."""
