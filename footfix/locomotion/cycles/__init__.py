"""Walking and running of any speed, from a model of a figure's own cycles."""
