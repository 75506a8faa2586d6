"""One simulation and many: plant, first state, solver choice, runs, their energy, and laws written in Python."""
