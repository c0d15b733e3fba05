"""The planner alone, without a simulation: the time that a robot needs to throw from my belt into my bins."""

import numpy as np

from pnt_gym.planning import EllipticWorkspace, MotionLimits, plan_release_batch

picks = np.array([[x, -0.30, -0.85] for x in (-0.25, 0.0, 0.25)])
bins = {"near": (0.30, 0.40, -0.85), "far": (0.45, 0.65, -0.85), "across the hall": (0.0, 2.5, -0.85)}
workspace = EllipticWorkspace(z_min=-1.0, z_max=-0.5)

for name, place in bins.items():
    plans = plan_release_batch(
        picks, np.tile(place, (len(picks), 1)), MotionLimits.t3kr(45.0), ceiling=-0.75, workspace=workspace
    )
    if plans.feasible.all():
        print(f"{name}: release after {1000 * plans.time.max():.0f} ms at {plans.speed.max():.2f} m/s")
    else:
        print(f"{name}: {(~plans.feasible).sum()} of {len(picks)} picks have no throw")
