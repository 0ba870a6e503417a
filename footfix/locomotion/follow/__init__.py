"""Walks laid along a path, handed over from one style to another, with strides, lean and balance."""
