"""Captured walks along a path: blends between styles, stride length, lean and balance."""
