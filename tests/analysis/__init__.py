"""Modes, linear models, equilibria and holding torques against closed forms and against simulated motion."""
