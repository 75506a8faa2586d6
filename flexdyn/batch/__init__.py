"""Batch studies: thousands of runs over drawn numbers, stored chunk by chunk, on all cores or a cluster."""
