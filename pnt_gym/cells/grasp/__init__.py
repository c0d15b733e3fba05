"""The conveyor's cell with surfaces that one sees, and two decisions for each object: where to grasp, how to throw."""
