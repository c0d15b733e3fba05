"""Robots: kinematics, dynamics and MuJoCo models."""
