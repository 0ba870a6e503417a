"""Loops: find where a walk repeats, join its ends, and hold its plants across the seam."""
