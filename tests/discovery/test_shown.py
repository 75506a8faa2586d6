"""No case hides a number that the tolerance of the others makes up for."""

from __future__ import annotations

import numpy as np
import pytest
from arm_draw import TwoLinkArm, draw_arm
from cases import make_case
from choice import chosen
from hidden import number_of, true_arm
from model_text import TOLERANCE, mistaken
from scipy.optimize import least_squares
from score import INSEPARABLE
from shown import NUMBERS, shown

WRONG = [(name, j) for name, j in NUMBERS if name != "tool"]


def with_logs(arm: TwoLinkArm, logs: np.ndarray) -> TwoLinkArm:
    """The arm with its numbers times exp(logs)."""
    pairs = dict(zip(NUMBERS, np.exp(logs), strict=True))
    names = ("mass", "com", "inertia")
    changed = {name: tuple(np.array(getattr(arm, name)) * [pairs[name, 0], pairs[name, 1]]) for name in names}
    return arm.replace(**changed, tool=arm.tool * pairs["tool", 0])


def least(true: TwoLinkArm, given: TwoLinkArm) -> float:
    """Least sum of squares, in tolerances, of changes after which the given arm moves as the true one; by a penalty."""
    seen = 5 if true.vertical else 3
    goal = true.links()[:seen]

    def miss(x: np.ndarray) -> np.ndarray:
        moves = with_logs(given, TOLERANCE * x).links()[:seen] / goal - 1.0
        return np.concatenate([x, 1e5 * moves])

    starts = (np.zeros(len(NUMBERS)), np.full(len(NUMBERS), 2.0))
    return min(2.0 * float(least_squares(miss, start, xtol=1e-12).cost) for start in starts)


@pytest.mark.parametrize("wrong", WRONG, ids=str)
def test_what_shows_is_what_no_other_numbers_make_up_for(wrong: tuple[str, int]) -> None:
    """Against an optimiser with a penalty on the same arms, but for those within a quarter of the bound."""
    asked = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        arm = draw_arm(rng)
        given = mistaken(arm, rng, 0.03, 0.02, at_edge=False)
        name, j = wrong
        own = list(getattr(arm, name))
        given = given.replace(**{name: tuple(given_ if k != j else own[j] for k, given_ in enumerate(own))})
        own[j] *= rng.choice([0.75, 1.3])
        true = arm.replace(**{name: tuple(own)})
        logs = [np.log(np.ravel(getattr(true, n))[k] / np.ravel(getattr(given, n))[k]) for n, k in NUMBERS]
        others = np.array([each != wrong for each in NUMBERS])
        delta = least(true, given) - ((np.array(logs) / TOLERANCE)[others] ** 2).sum()
        if abs(delta / INSEPARABLE - 1.0) > 0.25:
            asked += 1
            assert shown(true, given, wrong) == (delta > INSEPARABLE), (seed, delta)
    assert asked > 5


def test_cases_hide_wrong_numbers_that_show() -> None:
    """All of them on links, in one round through what can be hidden; the other cases need not be made."""
    sites = {number: chosen("single", 4, number)[0] for number in range(90)}
    wrong = [number for number, site in sites.items() if site[0] == "parameter_error" and site[2].startswith("link_")]
    assert len(wrong) >= 5
    for number in [*wrong, next(number for number, site in sites.items() if site[0] == "payload")]:
        case = make_case("single", 4, number, 1.0, 1.0)
        (one,) = case.hidden
        assert shown(true_arm(case.arm, one), case.given, ("tool", 0) if one.effect == "payload" else number_of(one))
