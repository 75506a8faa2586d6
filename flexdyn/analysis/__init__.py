"""Modes, linear models, frequency responses, equilibria, holding torques, base parameters, steady friction."""
