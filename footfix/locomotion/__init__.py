"""New motion made from captured motion: loops, walks along paths, and a locomotion engine."""
