"""The pages for a browser: one HTML file each, which loads no other files."""
