"""Which joints are legs, where the soles are, how large and which way up the figure is."""
