"""flexdyn."""
