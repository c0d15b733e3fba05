"""What holds an object: whether the cup seals and holds, how the lip yields, and how an object leaves it."""
