"""What a clip's feet do, in numbers."""
