"""The gripper robot's cell: small objects gripped by friction, tossed into a tray by opening the claws in motion."""
