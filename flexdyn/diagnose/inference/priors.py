"""How large an effect, a number and a parameter may be, before any data: see docs/diagnosis.md, "Priors"."""

EFFECT_TORQUE_SHARE = 0.3
"""Prior standard deviation of an effect's torque, as a share of the joint's root mean square torque."""
FREED_WIDTH = 1.0
"""Prior standard deviation of the factor of a number whose tolerance is wrong [1]."""
FREED_TOLERANCES = 10.0
"""The same in tolerances, where the tolerance itself is wider than `FREED_WIDTH`."""
EVERY_MOTOR = "of every motor:"
"""What the group of a kind begins with that every motor has."""
UNKNOWN_WIDTH = 1e4
"""Prior standard deviation of a parameter of which nothing is known, in units of a hundredth of its value."""
FITTED_SIZE_WIDTH = 1e-4
"""Prior standard deviation of the size of an effect as it was fitted: its tangents say what changes [1]."""
SMALLEST_TORQUE_SHARE = 4e-3
"""Share of its joint's torque from which an effect is one [1]. No model of a robot is right to less."""
FIXED_SIZE_WIDTH = 0.05
"""Prior standard deviation of the size of an effect that enters at one grid point, about 1: the grid is that coarse."""
