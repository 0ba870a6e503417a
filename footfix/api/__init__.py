"""The Python interface: files and arrays in, corrected motion, contacts, measures and reports out.

Positions in a Clip are parent-local, in metres, y up; rotations are unit quaternions xyzw. What is handed in is
checked, and refused in words (`ArgumentError`) where it can't be what is meant. `footfix` itself has all the names.
"""

from footfix.api.clips import clean, detect, find_rig
from footfix.api.files import load, save

__all__ = ["clean", "detect", "find_rig", "load", "save"]
