"""Many files: inputs -> tasks -> file results, in this process, on several processes, or on a cluster."""
