"""Families of cases, and which effects a case of a family hides."""

from __future__ import annotations

import numpy as np
from hidden import Site, sites
from sizes import FRICTION as LAWS

FAMILIES = ("single", "hard", "pair", "motor_only", "link_only", "rigid", "none", "outside", "triple")
"""Their order is part of the seeds: new ones stand at the end."""
TOGETHER = {"pair": 2, "triple": 3}
"""Effects that are hidden at once, where there is more than one."""


def possible(family: str) -> list[Site]:
    """What can be hidden in a family; no arm shows much of its first link's own inertia: its mass takes the place."""
    missing = {"motor_only": "q", "link_only": "theta"}.get(family)
    spring = "joint_elasticity"
    unseen = ("parameter_error", 0, "link_inertia")
    known = [("parameter_error", 0, "link_mass") if site == unseen else site for site in sites()]
    found = [site for site in known if missing is None or site[2] != missing]
    if family == "rigid":
        wound = {"transmission", "load_dependent_friction", "theta", "stiffness"}
        twice = [(name, j, "link") for name in LAWS for j in (0, 1)]  # the motor's side is the same there
        return [s for s in found if s[0] == spring or not ({s[0], s[2]} & wound or s in twice)]
    return found


def chosen(family: str, seed: int, number: int) -> list[Site]:
    """Sites of a case: number by number through a permutation of all, so that a batch holds all about equally often."""
    order = np.random.default_rng([seed, 1, FAMILIES.index(family)])
    known = possible(family)
    rounds, place = divmod(number, len(known))
    for _ in range(rounds + 1):
        permutation = order.permutation(len(known))
    found = [known[permutation[place]]]
    rng = np.random.default_rng([seed, 2, number])
    while len(found) < TOGETHER.get(family, 1):
        others = [site for site in known if all(_together(one, site) for one in found)]
        found.append(others[rng.integers(len(others))])
    return found


def _together(one: Site, two: Site) -> bool:
    """Whether two effects can be told from one another and from one effect alone."""
    if one[0] == two[0] and one[1] == two[1]:
        return False
    same_place = one[1:] == two[1:]
    if same_place and one[2] in ("q", "theta"):
        return False
    elasticity = "joint_elasticity" in (one[0], two[0]) and one[1] == two[1]
    removed = any(a[0] == "parameter_error" and _removes(b, a) for a, b in ((one, two), (two, one)))
    contains = {"coulomb_friction", "asymmetric_friction", "presliding_friction"}
    nested = same_place and (
        {one[0], two[0]} <= contains or {one[0], two[0]} <= {"viscous_friction", "warm_up_friction"}
    )
    # An asymmetry is an offset beside symmetric friction; cables imitate a spring over a short range.
    alike = ({"asymmetric_friction", "torque_offset"}, {"parallel_spring", "position_torque"})
    imitates = same_place and {one[0], two[0]} in alike
    return not (elasticity or removed or nested or imitates)


def _removes(site: Site, wrong: Site) -> bool:
    """Whether hiding the first takes the number out of the model file that the second says is wrong."""
    if site[1] != wrong[1] or site[2] != "motor":
        return False
    coulomb = ("coulomb_friction", "asymmetric_friction", "presliding_friction")
    return (wrong[2] == "level" and site[0] in coulomb) or (wrong[2] == "coefficient" and site[0] == "viscous_friction")
