"""Tests that state physics: trajectories, orders of convergence, energy."""
