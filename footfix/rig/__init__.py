"""The rig: which joints are legs, where the soles are, the figure's size and its up axis."""
