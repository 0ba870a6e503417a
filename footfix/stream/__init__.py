"""A live clip: rows in, rows out after a fixed look-ahead, with its feet held where they are planted."""
