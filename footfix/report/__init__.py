"""What people and CI read."""
