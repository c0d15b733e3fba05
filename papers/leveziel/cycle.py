"""The pick-and-drop cycle of a cork by the prototype of Leveziel et al. (Fig. 8, section VI-B), simulated."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Any, Final

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, frames_figure, subplots
from agents.ground.metrics import wilson
from agents.reproduce.finding import Findings, Row, share
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats
from pnt_gym.cells.base.canvas import Canvas, Frame
from pnt_gym.cells.gripper.outcome import BRUSHING
from pnt_gym.engine import mujoco
from pnt_gym.robots.gripper import MOTOR_SPEED, PROTOTYPE, inverse_kinematics, travel_time
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD

from .cases import STILL
from .cycle_run import ACROSS, HEIGHT, RISE, Cycles, run_cycles

CYCLES: Final = 100
SEED: Final = 0
NEARLY: Final = 0.05
"""Relative difference up to which a displacement counts as "around" the paper's."""
RELIABLE: Final = 0.95
"""Share of the cycles that have to succeed; the paper shows one cycle."""
NEAR: Final = 0.001
"""Distance from a leg's end at which the platform counts as arrived [m]."""
HEIGHTS: Final = (-0.175, -0.200, -0.225, -0.250)
"""Heights at which a move of 70 mm from the axis outwards is timed [m]."""
MILLI: Final = 1e3
NOZZLE: Final = 0.7e-3
"""Diameter of the nozzle of a small vacuum ejector, assumed [m]."""
SUPPLY, ATMOSPHERE = 5e5, 101_325.0
"""Pressure of the compressed air above the atmosphere, assumed, and pressure of the atmosphere [Pa]."""
GAS, AIR_TEMPERATURE = 287.0, 293.0
"""Gas constant of air [J/(kg K)], and its temperature [K]."""
SIZE: Final = (400, 340)
"""Height and width of a picture [pixels]."""
PICTURES: Final = (
    ("before", "lower", 0.0),
    ("lowered", "lower", 1.0),
    ("gripped", "close", 1.0),
    ("50 mm up", "lift", 1.0),
    ("half across", "across", 0.5),
    ("70 mm across", "stand", 1.0),
    ("opened", "open", 1.0),
    ("back", "rest", 1.0),
)
"""Pictures of the cycle: title, phase, and moment as a share of the phase's time."""


def cycle_findings(cycles: int = CYCLES) -> Findings:
    """The cycle at the motors' full speed, simulated once without mismatch and many times with full mismatch."""
    calm, realistic = (run_cycles(n, mismatch=m, share=1.0, seed=SEED) for n, m in ((1, 0.0), (cycles, 1.0)))
    where = f"{cycles} simulated cycles at 70 rpm, every unmodelled effect at its realistic strength, seed {SEED}"
    rows = (
        *_displacement_rows(realistic, where),
        _success_row(realistic, where),
        _grip_row(realistic, where),
        *_angle_rows(calm, realistic, where),
        *_leg_rows(realistic, where),
        _grasp_row(realistic, where),
        _cycle_time_row(realistic, where),
        *_comparison_rows(realistic, where),
    )
    drawn = {
        "leveziel_cycle.svg": cycle_figure(realistic),
        "leveziel_cycle_pictures.svg": frames_figure(pictures(realistic)),
    }
    data = {"leveziel_cycle": {"phase_ends_s": dict(realistic.course.ends)}}
    return table_findings("The cork cycle in the simulator", rows, drawn, data, drop="leveziel/cycle/")


def _displacement_rows(cycles: Cycles, where: str) -> Iterator[Row]:
    """Rows with the cork's displacement up to the command to open the claws."""
    begin, end = cycles.phase_steps("lift").start, cycles.phase_steps("stand").stop - 1
    ways = cycles.cork[:, end] - cycles.cork[:, begin]
    for name, axis, published in (("rise", "z", RISE), ("across", "y", ACROSS)):
        way = ways[:, "xyz".index(axis)]
        details: dict[str, Any] = {"smallest": float(way.min()), "largest": float(way.max())}
        note = (
            f"of the cork along {axis}, mean at the end of the way across; {where}. The paper says around "
            f"{1e3 * published:.0f} mm"
        )
        mean = float(way.mean())
        within = share(published, NEARLY)
        yield Row.compared(f"leveziel/cycle/{name}", published, mean, "m", within=within, note=note, **details)


def _success_row(cycles: Cycles, where: str) -> Row:
    successes = cycles.outcome.is_success
    rate = wilson(int(successes.sum()), successes.size)
    note = f"corks that crossed the box's opening and lie in it: {where}; 95 % interval from {100.0 * rate.low:.0f} %"
    return Row.compared(
        "leveziel/cycle/success",
        "shown once",
        100.0 * rate.value,
        "%",
        holds=rate.value >= RELIABLE,
        note=note,
        cycles=int(successes.size),
        release_delay_mean_s=float(cycles.outcome.release_delay.mean()),
    )


def _grip_row(cycles: Cycles, where: str) -> Row:
    carried = slice(cycles.phase_steps("lift").start, cycles.phase_steps("stand").stop)
    contacts = cycles.pads[:, carried]
    plans, outcome = cycles.plans, cycles.outcome
    is_held = outcome.picked & (outcome.release_delay >= plans.open_time - plans.release_time)
    force = cycles.force[:, carried]
    both_pads = 100.0 * float(contacts.all(axis=2).mean())
    return Row.compared(
        "leveziel/cycle/held",
        "not released during the displacement",
        100.0 * float(is_held.mean()),
        "%",
        holds=bool(is_held.all()),
        note=f"cycles in which the cork is never free of the pads for {1e3 * BRUSHING:.0f} ms before they open: "
        f"{where}; both pads touch it {both_pads:.1f} % of the time from the lift on, pressed by {force.min():.1f} to "
        f"{force.max():.1f} N, and it moves by {1e3 * outcome.slip.max():.2f} mm along them at most",
        both_pads=both_pads,
        slip_max_m=float(outcome.slip.max()),
    )


def _angle_rows(calm: Cycles, realistic: Cycles, where: str) -> Iterator[Row]:
    """Rows with the change of the halves' angle on the way: by the commanded path alone, and by our simulated robot."""
    steps = slice(realistic.phase_steps("lift").start, realistic.phase_steps("across").stop)
    servo = PROTOTYPE_BUILD.servo
    torque_share = 100.0 * (1.0 - servo.speed / servo.no_load_speed)
    commanded = _largest_turn(calm.course.pose[None, steps, 3])
    ideal, worst = _largest_turn(calm.platform[:, steps, 3]), _largest_turn(realistic.platform[:, steps, 3])
    yield Row.compared(
        "leveziel/cycle/angle-change-in-closed-form",
        "constant",
        commanded,
        "deg",
        holds=commanded < STILL,
        note="largest change of the halves' angle in joint-linear moves that lift the cork and carry it across, in "
        "closed form: no spring, gain or torque of ours is in it",
    )
    yield Row.ours(
        "leveziel/cycle/angle-change",
        worst,
        "deg",
        beside="constant",
        note=f"the same in the simulator, with springs, gains and a torque curve of ours: {where}. The servos, which "
        f"at 70 rpm have {torque_share:.0f} % of their torque left, lag behind differently, which alone gives "
        f"{ideal:.1f} deg without any other effect",
        joint_linear_deg=commanded,
        without_mismatch_deg=ideal,
    )


def _largest_turn(theta: Floats) -> float:
    """Largest change of angles (N, M) [rad] from their first values [deg]."""
    return float(np.rad2deg(np.abs(theta - theta[:, :1])).max())


def _leg_rows(cycles: Cycles, where: str) -> Iterator[Row]:
    """Rows with times of the lift and of the way across: bound, command, simulation, and from the robot's axis."""
    theta, low, over = cycles.plans.theta[0, 1], cycles.plans.pick[0], cycles.plans.release[0]
    high, home, step = low + np.array([0.0, 0.0, RISE]), PROTOTYPE.home_theta, cycles.config.timestep
    ends = np.array([[0.0, 0.0, -0.250, home], [0.0, 0.0, -0.200, home]])
    up = float(travel_time(*ends))
    turn = np.abs(np.diff(inverse_kinematics(ends), axis=0)).max()
    outward_times = {1e3 * z: float(travel_time([0.0, 0.0, z, home], [0.0, ACROSS, z, home])) for z in HEIGHTS}
    outwards = ", ".join(f"{1e3 * seconds:.0f} ms at {z:.0f} mm" for z, seconds in outward_times.items())
    lift = (
        f"On the robot's axis, from -250 to -200 mm at -45 deg, it takes {1e3 * up:.1f} ms along a line, and "
        f"{1e3 * turn / MOTOR_SPEED:.1f} ms as a joint-linear move, which the paper makes"
    )
    across = f"From the robot's axis outwards at -45 deg it takes {outwards}"
    for name, start, end, from_axis, details in (
        ("lift", low, high, lift, {"on_axis_s": up}),
        ("across", high, over, across, {f"outwards_at_{z:.0f}mm_s": seconds for z, seconds in outward_times.items()}),
    ):
        steps = cycles.phase_steps(name)
        commanded = (steps.stop - steps.start) * step
        distances = np.linalg.norm(cycles.platform[:, steps.start :, :3] - end, axis=-1)
        arrival = float((distances < NEAR).argmax(axis=1).mean()) * step
        bound = float(travel_time(np.append(start, theta), np.append(end, theta)))
        times = {"commanded_s": commanded, "simulated_s": arrival, **details}
        note = (
            f"all the way at 70 rpm of the fastest motor, here with closed claws and a platform at {HEIGHT:g} m; no "
            f"time is published. {from_axis}. The trapezoid with ramps of a quarter each takes "
            f"{1e3 * commanded:.0f} ms, and the simulated platform is within 1 mm after {1e3 * arrival:.0f} ms on "
            f"average; {where}"
        )
        yield Row.ours(f"leveziel/cycle/{name}-time", bound, "s", note=note, **times)


def _grasp_row(cycles: Cycles, where: str) -> Row:
    begin = cycles.phase_steps("close").start
    both_pads = cycles.pads[:, begin:].all(axis=2)
    seconds = both_pads.argmax(axis=1) * cycles.config.timestep
    theta = np.rad2deg(cycles.plans.theta[0])
    note = (
        f"from the command to close until both pads touch, mean; {where}. The halves go from {theta[0]:.0f} to "
        f"{theta[2]:.0f} deg until then and are told to go on to {theta[1]:.0f} deg; the paper's 60 ms are for 15 deg "
        "from -45 deg"
    )
    return Row.ours("leveziel/cycle/grasp-time", float(seconds.mean()), "s", note=note, largest=float(seconds.max()))


def _cycle_time_row(cycles: Cycles, where: str) -> Row:
    ends = cycles.course.ends
    seconds, stall = ends["back"], PROTOTYPE_BUILD.servo.stall_torque
    moving = cycles.torque[:, : cycles.phase_steps("back").stop]
    full = 100.0 * float((np.abs(moving) > 0.999 * stall).mean())
    note = (
        f"lower, close, lift, across, stand, open, back above the pick: {60.0 / seconds:.0f} per minute. A motor is at "
        f"its stall torque {full:.1f} % of that time; {where}"
    )
    details = {"per_minute": 60.0 / seconds, "at_stall_torque": full}
    return Row.ours("leveziel/cycle/cycle-time", seconds, "s", note=note, **details)


def _comparison_rows(cycles: Cycles, where: str) -> Iterator[Row]:
    """Rows beside what the paper says of other machines: picks a minute, and energy by motors and by suction."""
    beside = "70 of sorting machines, 30 to 40 of people, 30 with grippers on gantries"
    note = (
        "cycles of the prototype at its motors' full speed, without finding, belt and waste: a bound, not a pick rate"
    )
    yield Row.ours(
        "leveziel/cycle/picks-per-minute", 60.0 / cycles.course.ends["back"], "1/min", beside=beside, note=note
    )
    end, step = cycles.phase_steps("back").stop, cycles.config.timestep
    speed = np.gradient(cycles.angle[:, :end], step, axis=1)
    work = np.maximum(cycles.torque[:, :end] * speed, 0.0).sum(axis=(1, 2)) * step
    yield Row.ours(
        "leveziel/cycle/motor-work",
        float(work.mean()),
        "J",
        beside="energy-efficient",
        note="mechanical work of the four motors in a cycle, what they give back while they brake not deducted; losses "
        f"in the windings are not in it, since no resistance is published. The grip takes no motor of its own; {where}",
        largest=float(work.max()),
    )
    held = (cycles.phase_steps("stand").stop - cycles.phase_steps("close").start) * step
    yield Row.ours(
        "leveziel/cycle/suction-work",
        held * ejector_power(),
        "J",
        beside="far from energy-efficient",
        note=f"work of an ideal compressor for the air of an ejector that holds a cup for the same {held:.2f} s: a "
        f"nozzle of {1e3 * NOZZLE:g} mm (assumed, a small one) at {1e-5 * SUPPLY:g} bar above the atmosphere, "
        f"{ejector_power():.0f} W. Real compressors take about twice as much, and such a robot needs motors too",
    )


def ejector_power() -> float:
    """Least power [W] that compresses the air of an ejector: isothermal, for the choked flow through its nozzle."""
    pressure, heat = SUPPLY + ATMOSPHERE, GAS * AIR_TEMPERATURE
    # Mass flow of a choked nozzle, for a ratio of heats of 1.4 (any textbook of gas dynamics).
    flow = 0.6847 * 0.25 * np.pi * NOZZLE**2 * pressure / np.sqrt(heat)
    return float(flow * heat * np.log(pressure / ATMOSPHERE))


def cycle_figure(cycles: Cycles) -> Figure:
    """Drawing of the first cycle, commanded and simulated: motor angles, positions, the halves' angle, grip."""
    figure, axes = subplots(4, 1, (WIDTH, 11.0), sharex=True)
    time, course = cycles.time, cycles.course
    commanded = cycles.recording.control[:, 0:12:3]
    for k in range(4):
        # Motors 1 and 3 move alike in the plane between them.
        width = 3.5 if k == 0 else 1.5
        axes[0].plot(time, np.rad2deg(cycles.angle[0, :, k]), color=COLOURS[k], lw=width, label=f"motor {k + 1}")
        label = "commanded" if k == 3 else None
        axes[0].plot(time, np.rad2deg(commanded[:, k]), "--", color="black", linewidth=0.8, label=label)
    for axis, name, colour in ((1, "y", COLOURS[2]), (2, "z", COLOURS[3])):
        axes[1].plot(time, MILLI * cycles.platform[0, :, axis], color=colour, label=f"platform, {name}")
        axes[1].plot(time, MILLI * cycles.cork[0, :, axis], ":", color=colour, label=f"cork, {name}")
    axes[1].plot(time, MILLI * course.pose[:, 1:3], "--", color="black", linewidth=0.8)
    axes[2].plot(time, np.rad2deg(cycles.platform[0, :, 3]), color=COLOURS[0], label="simulated")
    axes[2].plot(time, np.rad2deg(course.pose[:, 3]), "--", color="black", linewidth=0.8, label="commanded")
    for k, side in enumerate(("right", "left")):
        axes[3].plot(time, cycles.force[0, :, k], color=COLOURS[k], label=f"{side} finger")
        # A bar as long as a pad touches the cork.
        touches = np.where(cycles.pads[0, :, k], -0.35 - 0.35 * k, np.nan)
        axes[3].plot(time, touches, color=COLOURS[k], linewidth=3, label=f"{side} pad touches")
    names = (
        "motor angle [°]",
        "position [mm]",
        "angle of the halves [°]",
        "force of the finger's spring\nat its pad [N]",
    )
    for panel, name in zip(axes, names, strict=True):
        dress(panel, "time [s]" if panel is axes[-1] else "", name)
        below = -0.25 if panel is axes[-1] else -0.02
        panel.legend(fontsize=8, ncols=5, loc="upper center", bbox_to_anchor=(0.5, below))
        for end in course.ends.values():
            panel.axvline(end, color="gray", linewidth=0.7)
    text_style = {"ha": "center", "va": "bottom", "fontsize": 8, "transform": axes[0].get_xaxis_transform()}
    for (name, end), begin in zip(course.ends.items(), (0.0, *course.ends.values()), strict=False):
        axes[0].text(0.5 * (begin + end), 1.02, name, **text_style)
    return figure


def pictures(cycles: Cycles) -> list[tuple[str, Frame]]:
    """Pictures of the first cycle with their titles, like the photographs of Fig. 8.

    Raises:
        ConfigError: this machine cannot draw.
    """
    course, step, frames = cycles.course, cycles.config.timestep, list[tuple[str, Frame]]()
    begins = dict(zip(course.ends, [0.0, *course.ends.values()], strict=False))
    upcoming = [
        (title, begins[phase] + share * (course.ends[phase] - begins[phase])) for title, phase, share in PICTURES
    ]
    # Along -x: y runs to the right.
    view = mujoco.MjvCamera()
    view.lookat[:] = [0.0, 0.0, -0.205]
    view.distance, view.azimuth, view.elevation = 0.60, 170.0, -24.0
    with closing(Canvas(view, SIZE)) as canvas:
        for data, _ in cycles.recording.play(step):
            while upcoming and data.time >= min(upcoming[0][1], float(cycles.time[-1])) - 0.5 * step:
                title, moment = upcoming.pop(0)
                frames.append((f"{title}, {MILLI * moment:.0f} ms", canvas.draw(cycles.recording.model, data, ())))
    return frames
