"""The pages that people open in a browser: one HTML file each, which loads nothing."""
