"""A cell of your own: a mapping, or a YAML file, of differences from a shipped level."""

import pnt_gym

cell = {
    "base": "waste",
    "name": "bottles",
    "items": ["pet_05", "pet_crushed"],
    "bins": {"fixed": [{"name": "left", "x": -0.25, "y": 0.45}, {"name": "right", "x": 0.25, "y": 0.45}]},
    "limits": {"percent": [40]},
}

figures = pnt_gym.evaluate("analytic", "PnTConveyor-v0", picks=32, level=cell)
pace, share = figures["sorted_per_min"], 100 * figures["success_rate"]
print(f"{pace:.1f} sorted a minute, {share:.0f} % of {figures['picks']} succeed")
