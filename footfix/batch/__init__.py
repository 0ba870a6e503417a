"""Many files: inputs -> jobs -> file results, in this process, on several, or on a cluster."""
