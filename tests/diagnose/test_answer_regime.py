"""The regime in which a residual stands out is named, with its bound."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexdyn.diagnose.answer.regime import Quantity, regime

Array = NDArray[np.float64]
BLOCKS = 1600


def motion() -> dict[str, Array]:
    """A made-up motion over 40 s, block by block."""
    t = np.linspace(0.0, 40.0, BLOCKS)
    u = np.sin(1.3 * t) * (0.1 + np.abs(np.sin(0.31 * t)))
    return {"t": t, "u": u, "q": np.sin(2.1 * t + 0.4), "load": 20.0 * np.cos(3.7 * t), "other": np.sin(4.3 * t) ** 3}


def quantities() -> list[Quantity]:
    """What it may depend on."""
    m = motion()
    return [
        Quantity("abs(omega) {} rad/s", np.abs(m["u"])),
        Quantity("omega {}", m["u"], signed=True),
        Quantity("abs(tau_s) {} N m", np.abs(m["load"])),
        Quantity("q {} rad", m["q"]),
        Quantity("t {} s", m["t"]),
        Quantity("abs(omega of elbow) {} rad/s", np.abs(m["other"])),
    ]


def noisy(excess: Array, seed: int = 1) -> Array:
    """Mean squares of five white residuals each of variance 1 + excess."""
    draw = np.random.default_rng(seed)
    return np.asarray((1.0 + excess) * draw.chisquare(5, len(excess)) / 5)


LAWS: dict[str, tuple[Callable[[dict[str, Array]], Any], str, tuple[float, ...]]] = {
    "low speed": (lambda m: 40.0 * np.exp(-2.0 * np.abs(m["u"]) / 0.1), r"abs\(omega\) < (\S+) rad/s", (0.12,)),
    "high speed": (lambda m: 40.0 * m["u"] ** 4, r"abs\(omega\) > (\S+) rad/s", (0.65,)),
    "direction": (lambda m: 20.0 * (m["u"] < 0.0), r"omega < (\S+)", (0.0,)),
    "load": (lambda m: 0.1 * m["load"] ** 2, r"abs\(tau_s\) > (\S+) N m", (13.0,)),
    "position": (lambda m: 30.0 * (np.abs(m["q"] - 0.5) < 0.25), r"q between (\S+) and (\S+) rad", (0.25, 0.75)),
    "end of the range": (lambda m: 30.0 * (m["q"] > 0.7), r"q > (\S+) rad", (0.7,)),
    "early": (lambda m: 60.0 * np.exp(-m["t"] / 4.0), r"t < (\S+) s", (9.0,)),
    "late": (lambda m: 20.0 * (m["t"] > 30.0), r"t > (\S+) s", (30.0,)),
    "another joint": (lambda m: 30.0 * m["other"] ** 2, r"abs\(omega of elbow\) > (\S+) rad/s", (0.45,)),
}


@pytest.mark.parametrize("name", LAWS)
def test_the_regime_is_named_with_its_bound(name: str) -> None:
    """Of all quantities the one the power depends on, bounded within a bin or two."""
    law, pattern, bounds = LAWS[name]
    said = regime(noisy(law(motion())), quantities())
    found = re.fullmatch(pattern, said)
    assert found, said
    scale = max(*(abs(b) for b in bounds), 0.1)
    assert [float(x) for x in found.groups()] == pytest.approx(list(bounds), abs=0.35 * scale)


def test_two_conditions_at_once() -> None:
    """Friction that fades as the gear warms up: early, and the more the faster."""
    m = motion()
    said = regime(noisy(4000.0 * m["u"] ** 4 * np.exp(-m["t"] / 8.0)), quantities())
    assert re.fullmatch(r"t < \S+ s and abs\(omega\) > \S+ rad/s|abs\(omega\) > \S+ rad/s and t < \S+ s", said), said


@pytest.mark.parametrize("seed", range(5))
def test_noise_has_no_regime(seed: int) -> None:
    """Neither has noise alone nor an excess that is the same throughout."""
    assert regime(noisy(np.zeros(BLOCKS), seed), quantities()) == "everywhere"
    assert regime(noisy(np.full(BLOCKS, 5.0), seed), quantities()) == "everywhere"
