"""The objects: what is true of each, what sensors say of it, how they are drawn, and how they fill bins."""
