"""Holding plants where they are planted: targets, inverse kinematics, root-only correction."""
