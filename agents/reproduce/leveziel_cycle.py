"""The pick-and-drop cycle of a cork by the prototype of Leveziel et al. (Fig. 8, section VI-B), simulated."""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.report.figures import frames_figure, svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.leveziel_cycle_drawings import cycle_figure, pictures
from agents.reproduce.leveziel_cycle_run import ACROSS, HEIGHT, RISE, Cycles, run_cycles
from pnt_gym.cells.tray.simulated import BRUSHING
from pnt_gym.metrics import wilson
from pnt_gym.planning.arrays import Floats
from pnt_gym.robots.gripper4 import PROTOTYPE, travel_time
from pnt_gym.robots.gripper4.build import PROTOTYPE_BUILD

CYCLES: Final = 100
SEED: Final = 0
CONSTANT: Final = 0.5
"""An angle counts as constant that changes by less than this [deg]."""
AROUND: Final = 0.05
"""Share of a displacement within which it counts as the paper's."""
NEAR: Final = 0.001
"""A leg is over when the platform comes this near to its end [m]."""
HEIGHTS: Final = (-0.175, -0.200, -0.225, -0.250)
"""At which 70 mm from the axis outwards are timed [m]."""


def cycle_findings(cycles: int = CYCLES) -> Findings:
    """The cycle at the motors' full speed, once without anything unknown and many times with it."""
    calm, many = (run_cycles(n, mismatch=m, share=1.0, seed=SEED) for n, m in ((1, 0.0), (cycles, 1.0)))
    where = f"{cycles} simulated cycles at 70 rpm, every unmodelled effect at its realistic strength, seed {SEED}"
    rows = (
        *_displacements(many, where),
        _success(many, where),
        _held(many, where),
        _angle(calm, many, where),
        *_legs(many, where),
        _grasp(many, where),
        _whole(many, where),
    )
    figures = {
        "leveziel_cycle.svg": svg(cycle_figure(many)),
        "leveziel_cycle_pictures.svg": svg(frames_figure(pictures(many), columns=4, width=11.0)),
    }
    return Findings(rows, {"leveziel_cycle": {"phase_ends_s": dict(many.course.ends)}}, figures)


def _displacements(cycles: Cycles, where: str) -> list[Row]:
    """How far the cork has come when the claws are told to open."""
    begin, end = cycles.during("lift").start, cycles.during("stand").stop - 1
    way = cycles.cork[:, end] - cycles.cork[:, begin]
    return [
        Row(
            f"leveziel/cycle/{name}",
            asked,
            float(way[:, axis].mean()),
            "m",
            "reproduced" if abs(way[:, axis].mean() - asked) < AROUND * asked else "differs",
            f"of the cork along {'xyz'[axis]}, mean at the end of the way across; {where}. The paper says around "
            f"{1e3 * asked:.0f} mm",
            {"smallest": float(way[:, axis].min()), "largest": float(way[:, axis].max())},
        )
        for name, axis, asked in (("rise", 2, RISE), ("across", 1, ACROSS))
    ]


def _success(cycles: Cycles, where: str) -> Row:
    done = cycles.outcome.is_success
    rate = wilson(int(done.sum()), done.size)
    return Row(
        "leveziel/cycle/success",
        "shown once",
        100.0 * rate.value,
        "%",
        "reproduced" if rate.value >= 0.95 else "differs",
        f"corks at rest in the box at the end: {where}; 95 % interval from {100.0 * rate.low:.0f} %",
        {"cycles": int(done.size), "release_delay_mean_s": float(cycles.outcome.release_delay.mean())},
    )


def _held(cycles: Cycles, where: str) -> Row:
    carried = slice(cycles.during("lift").start, cycles.during("stand").stop)
    touched = cycles.pads[:, carried]
    plans, outcome = cycles.plans, cycles.outcome
    held = outcome.picked & (outcome.release_delay >= plans.open_time - plans.release_time)
    claws = PROTOTYPE_BUILD.claws
    force = np.abs(cycles.bend[:, carried]) * claws.stiffness / claws.length
    both = 100.0 * float(touched.all(axis=2).mean())
    return Row(
        "leveziel/cycle/held",
        "not released during the displacement",
        100.0 * float(held.mean()),
        "%",
        "reproduced" if held.all() else "differs",
        f"cycles in which the cork is never free of the pads for {1e3 * BRUSHING:.0f} ms before they open: {where}; "
        f"both pads touch it {both:.1f} % of the time from the lift on, pressed by {force.min():.1f} to "
        f"{force.max():.1f} N, and it moves by {1e3 * outcome.slip.max():.2f} mm along them at most",
        {"both_pads": both, "slip_max_m": float(outcome.slip.max())},
    )


def _angle(calm: Cycles, many: Cycles, where: str) -> Row:
    moved = slice(many.during("lift").start, many.during("across").stop)
    asked = _turned(calm.course.pose[None, moved, 3])
    ideal, worst = _turned(calm.platform[:, moved, 3]), _turned(many.platform[:, moved, 3])
    return Row(
        "leveziel/cycle/angle-change",
        "constant",
        worst,
        "deg",
        "reproduced" if worst < CONSTANT else "differs",
        f"largest change of the halves' angle while the cork is lifted and moved across: {where}. Joint-linear moves "
        f"turn the halves by {asked:.1f} deg on the way in closed form; the servos, which at 70 rpm have "
        f"{100.0 * _torque_left():.0f} % of their torque left, lag behind differently, which alone gives "
        f"{ideal:.1f} deg without any other effect",
        {"joint_linear_deg": asked, "without_mismatch_deg": ideal},
    )


def _turned(theta: Floats) -> float:
    """Largest change (N, M) from the beginning [deg]."""
    return float(np.rad2deg(np.abs(theta - theta[:, :1])).max())


def _torque_left() -> float:
    servo = PROTOTYPE_BUILD.servo
    return 1.0 - servo.speed / servo.no_load_speed


def _legs(cycles: Cycles, where: str) -> list[Row]:
    """Times of the lift and of the way across: bound, command, simulated."""
    rows: list[Row] = []
    theta, low, over = cycles.plans.theta[0, 1], cycles.plans.pick[0], cycles.plans.release[0]
    high = low + np.array([0.0, 0.0, RISE])
    for name, ends in (("lift", (low, high)), ("across", (high, over))):
        start, end = (np.append(place, theta) for place in ends)
        steps = cycles.during(name)
        asked = (steps.stop - steps.start) * cycles.config.timestep
        away = np.linalg.norm(cycles.platform[:, steps.start :, :3] - ends[1], axis=-1)
        passed = float((away < NEAR).argmax(axis=1).mean()) * cycles.config.timestep
        bound = float(travel_time(start, end))
        details = {"commanded_s": asked, "simulated_s": passed, **_from_axis(name)}
        note = (
            f"all the way at 70 rpm of the fastest motor, here with closed claws and a platform at {HEIGHT:g} m; no "
            f"time is published. {_from_axis_note(name)}. The trapezoid with ramps of a quarter each takes "
            f"{1e3 * asked:.0f} ms, and the simulated platform is within 1 mm after {1e3 * passed:.0f} ms on average; "
            f"{where}"
        )
        rows.append(Row(f"leveziel/cycle/{name}-time", None, bound, "s", "ours", note, details))
    return rows


def _from_axis(name: str) -> dict[str, float]:
    """Speed-limited times [s] on the robot's axis and from it outwards, at the home angle."""
    theta = PROTOTYPE.home_theta
    if name == "lift":
        return {"on_axis_s": float(travel_time([0.0, 0.0, -0.250, theta], [0.0, 0.0, -0.200, theta]))}
    return {
        f"outwards_at_{1e3 * z:.0f}mm_s": float(travel_time([0.0, 0.0, z, theta], [0.0, ACROSS, z, theta]))
        for z in HEIGHTS
    }


def _from_axis_note(name: str) -> str:
    times = [1e3 * seconds for seconds in _from_axis(name).values()]
    if name == "lift":
        return f"On the robot's axis, from -250 to -200 mm at -45 deg, it takes {times[0]:.0f} ms"
    listed = ", ".join(f"{t:.0f} ms at {1e3 * z:.0f} mm" for t, z in zip(times, HEIGHTS, strict=True))
    return f"From the robot's axis outwards at -45 deg it takes {listed}"


def _grasp(cycles: Cycles, where: str) -> Row:
    begin = cycles.during("close").start
    both = cycles.pads[:, begin:].all(axis=2)
    seconds = both.argmax(axis=1) * cycles.config.timestep
    theta = np.rad2deg(cycles.plans.theta[0])
    mean = float(seconds.mean())
    return Row(
        "leveziel/cycle/grasp-time",
        None,
        mean,
        "s",
        "ours",
        f"from the command to close until both pads touch, mean; {where}. The halves go from {theta[0]:.0f} to "
        f"{theta[2]:.0f} deg until then and are told to go on to {theta[1]:.0f} deg; the paper's 60 ms are for 15 deg "
        "from -45 deg",
        {"largest": float(seconds.max())},
    )


def _whole(cycles: Cycles, where: str) -> Row:
    ends = cycles.course.ends
    seconds, stall = ends["back"], PROTOTYPE_BUILD.servo.stall_torque
    moving = cycles.torque[:, : cycles.during("back").stop]
    full = 100.0 * float((np.abs(moving) > 0.999 * stall).mean())
    return Row(
        "leveziel/cycle/cycle-time",
        None,
        seconds,
        "s",
        "ours",
        f"lower, close, lift, across, stand, open, back above the pick: {60.0 / seconds:.0f} per minute. A motor is at "
        f"its stall torque {full:.1f} % of that time; {where}",
        {"per_minute": 60.0 / seconds, "at_stall_torque": full},
    )


PARTS = (Part("cycle", cycle_findings),)
