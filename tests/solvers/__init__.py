"""What the solvers promise: exact sticking, located events, order, stability."""
