"""Hypotheses compared by simulations: numbers are fitted to windows, and structures are compared by them."""
