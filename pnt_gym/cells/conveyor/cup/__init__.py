"""The suction cup: whether it seals and holds, how its lip bends, and how an object leaves it."""
