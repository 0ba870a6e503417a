"""Correct a clip so that planted feet stay where they are: one least-squares problem over all frames."""
