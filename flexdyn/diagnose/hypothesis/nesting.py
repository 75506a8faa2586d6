"""Which effects contain which others: in a limit of their numbers they become them."""

CONTAINS = {
    "asymmetric_friction": ("coulomb_friction", "torque_offset"),
    "presliding_friction": ("coulomb_friction", "viscous_friction"),
    "warm_up_friction": ("viscous_friction",),
    "position_dependent_friction": ("coulomb_friction",),
}
"""Effects that become others in a limit."""
