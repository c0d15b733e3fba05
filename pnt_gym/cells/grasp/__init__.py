"""The conveyor's cell with objects that one can see, and with two decisions for each: where to grasp, and how to throw."""
