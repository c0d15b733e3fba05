"""The conveyor's cell with surfaces that one sees, and two decisions for each object: where to grasp, how to throw."""

from pnt_gym.deferred import defer

defer(__name__, "image_kernel", "random_kernel", "seal_kernel", "surface_kernel")
