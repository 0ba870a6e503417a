"""New motion out of captured motion."""
