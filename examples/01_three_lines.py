"""An environment in three lines: one step is one throw, and action zero is the analytic planner's own throw."""

import gymnasium as gym

import pnt_gym  # noqa: F401 - registers the environments

env = gym.make("PnTConveyor-v0", level="waste")
observation, info = env.reset(seed=3)
observation, reward, terminated, truncated, info = env.step([0.0, 0.0])

print(f"{info['kind']=} {info['is_success']=} {info['landing_error']=:.3f} m {info['cycle_time']=:.2f} s")

observation, info = env.reset(options={"item": "can"})  # what is thrown first may be asked for
print(f"next comes a {env.unwrapped.core.item_names[info['kind']]}")
