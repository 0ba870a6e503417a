"""Doors: files to values and back."""
