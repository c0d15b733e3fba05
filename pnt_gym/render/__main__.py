"""Whether this machine can draw: `python -m pnt_gym.render`."""

from pnt_gym.render.canvas import rendering_problem

if __name__ == "__main__":
    print(rendering_problem() or "rendering works on this machine")
