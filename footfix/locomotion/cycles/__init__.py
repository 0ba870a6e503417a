"""Locomotion engine: walking and running at any speed, from a model of a figure's own cycles."""
