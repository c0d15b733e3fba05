"""Words for the drawings of the pages of tables, by the file's name."""

from __future__ import annotations

from pathlib import Path
from typing import Final

BENCHMARK: Final = {
    "sorted_per_min": "Sorted picks per minute over the throws learned from; controllers that do not learn are lines.",
    "landing_error": "Mean landing error of every controller, with 95 % intervals.",
    "landing_clouds": "Landings against the target, along and across the throw; the cross is their mean.",
    "over_the_shift": "Mean landing error over the picks of a shift, level by level.",
    "value": "Gain in value per minute over first in, first out, with 95 % intervals.",
    "profiles": "Share of the runs, over seeds and levels, that err or fail less than a bound, with 95 % intervals.",
    "learning_curves": "Each controller over the throws or decisions learned from; dashed: it does not learn.",
}
"""Drawings of benchmarks; the files of further benchmarks have the same names after the name of the benchmark."""
STUDIES: Final = {
    "methods": "Sorted picks per minute of each way to the bin, over the robot's limits in two levels, and over the "
    "opening of the bin, its distance and the mass of the objects.",
    "curves": "Landing error and sorted objects per minute over the throws learned from: mean and range of the seeds.",
    "curves_profiles": "Share of the runs that err less than a bound, after the most throws.",
    "mismatch": "Gain of learning over the planner in landing error and in sorted objects, with 95 % intervals.",
}
PAPERS: Final = {
    "hassan_scurve": "Time and peak speed over the stroke (Fig. 2), and the release as a crossing (Figs. 4 and 5).",
    "hassan_paths": "The first cycle inside at 30 %, from the side: hand and thrown object (Figs. 8 to 10).",
    "hassan_positions_place_inside": "Planned positions over time, pick-and-place and the minimum-time throw, inside.",
    "hassan_positions_inside": "Planned positions over time, horizontal and minimum-time throw, inside.",
    "hassan_positions_outside": "Planned positions over time, horizontal and minimum-time throw, outside.",
    "hassan_motion": "Position, speed, acceleration and jerk of the loop at 30 % (Fig. 12), in three readings.",
    "hassan_table1": "Picks per minute over the percentage of the limits, published and by the main readings.",
    "hassan_picks_per_min": "Picks per minute of the proposed throw in every cell of Table I: published, reproduced, "
    "and in a free direction.",
    "hassan_free_direction": "The straight throw and the throw in a free direction: side view, speed, acceleration.",
    "choe_ellipse": "The published example with its vertical parts, axes and top, and ellipses with other tops.",
    "choe_length": "Length over the angle of the major axis (Fig. 2), and clearance by the rule of whole degrees.",
    "choe_curvature": "Radius of curvature over the polar angle, and its first two derivatives (Fig. 3).",
    "choe_profile": "Curvature, displacement, velocity, acceleration and jerk at the knots (Fig. 5).",
    "choe_nodes": "The node list, radius of curvature and steps along the path, and the quickest motion (Fig. 6).",
    "choe_joints": "Arm angles of our robot along the example (Fig. 7), and in the quickest motion.",
    "choe_lengths": "The curves of Fig. 8 under two readings of the comparison.",
    "choe_times": "Each path over the long way, and the time along the path.",
    "choe_motions": "Speed, acceleration and jerk over time, for paths on which the hand stops, steps or runs through.",
    "choe_scene": "The way of one object out of one box and into another, seen from the side.",
    "miyashita_motion": "Arm and block from rest to the goal (Fig. 5).",
    "miyashita_trajectories": "Angle, speed, acceleration and torque up to the release (Fig. 6), for several weights.",
    "miyashita_margin": "The moment M_A up to the release, with and without a maximised margin (Fig. 7).",
    "miyashita_accessible": "The accessible space in slices (Fig. 8), by the bound that admits each cell.",
    "miyashita_learning": "Errors over ten throws of learning (Fig. 10), for three delays of the release.",
    "miyashita_trials": "The arm's planned motion in every trial of the learning (Fig. 11).",
    "miyashita_sorting": "Flights into the three pallets, each past the other two (Fig. 13).",
    "miyashita_task_motions": "The arm's planned motions for sorting and assembly (Figs. 14 and 17).",
    "miyashita_assembly": "The assembly in pictures: an H onto the stand, a T onto the H (Fig. 16).",
    "miyashita_contact": "Errors over throws with stoppers that push the block: median and quartiles over the goals.",
    "miyashita_contact_reach": "Goals that some release reaches although the stoppers push the block.",
    "miyashita_contact_learning": "Share of the goals that each throw came near, with stoppers that push the block.",
    "leveziel_workspace": "Three sections of the workspace at -45 deg (Fig. 5).",
    "leveziel_theta": "Two sections of the workspace at other angles of the halves.",
    "leveziel_tau": "The platform index over the angle of the halves (Fig. 6), and 1 / tau at the gripping angles.",
    "leveziel_circle": "The circle of 80 mm in sections at some heights, and its share of area and radius.",
    "leveziel_turn": "Motor angles and speeds over a turn of the circle, with the gripper open and closed.",
    "leveziel_moves": "Angle of the halves and distance from the line over time, for lines and joint-linear moves.",
    "leveziel_closing": "Angle of the halves over time, for different commands to close.",
    "leveziel_cycle": "The first cycle, commanded and simulated: motor angles, positions, angle of the halves, grip.",
    "leveziel_cycle_pictures": "The cycle of the cork in pictures (Fig. 8).",
    "leveziel_grasps": "Way of the objects along the pads, over their direction against the pads.",
    "leveziel_release": "Landing along the throw over the time of the release.",
    "leveziel_toss": "Success and landing error over practice throws, by level: mean and range over seeds.",
}
CAPTIONS: Final = BENCHMARK | STUDIES | PAPERS


def caption(file: str) -> str:
    """Words for a drawing; the words of its name where it has no others."""
    name = Path(file).stem
    ending = next((ending for ending in BENCHMARK if name.endswith(f"_{ending}")), name)
    return CAPTIONS.get(name) or CAPTIONS.get(ending) or name.replace("_", " ")
