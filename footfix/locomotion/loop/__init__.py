"""Loops: where a walk repeats, how its ends are joined, and rounds held as one."""
