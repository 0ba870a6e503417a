"""Arrays: skeletons, clips, contacts, rotations, kinematics, smoothing."""
