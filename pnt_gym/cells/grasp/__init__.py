"""Seeing, grasping, throwing: the conveyor's cell with surfaces that one sees and on which a cup seals or leaks."""
