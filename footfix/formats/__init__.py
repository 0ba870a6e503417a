"""Files and what is in them: BVH, contact labels, bridges to other libraries."""
