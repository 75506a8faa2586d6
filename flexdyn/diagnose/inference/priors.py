"""How large an effect, a number and a parameter may be, before any data: see docs/diagnosis.md, "Priors"."""

EVERY_MOTOR = "of every motor:"
"""What the group of a kind begins with that every motor has."""
UNKNOWN_WIDTH = 1e4
"""Prior standard deviation of a parameter of which nothing is known, in units of a hundredth of its value."""
FITTED_SIZE_WIDTH = 1e-4
"""Prior standard deviation of the size of an effect as it was fitted: its tangents say what changes [1]."""
