"""Live cleaning: rows in, rows out after a fixed delay, with planted feet held in place."""
