"""When heel and toe of each foot are planted."""
