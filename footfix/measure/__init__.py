"""Measures of clips and plants, and the agreement of contact labels."""
