"""Hypotheses compared by what they simulate: numbers fitted over windows, and structures weighed by them."""
