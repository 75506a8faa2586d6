"""Double pendulum: the chain is the published one, and its published friction predicts records far better than none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pendulum_data import HERE, published, read_records, windows

import flexdyn as fd

DATA = Path(__file__).parents[3] / "shared" / "data" / "dfki_double_pendulum"
M1, M2, R1, R2, I1, I2, IR, GR = 0.52346023, 0.62556772, 0.2, 0.25569305, 0.0318872, 0.05086985, 6.287204e-5, 6.0
LENGTH, G = 0.2, 9.81

needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"{DATA} is absent: the pendulum's records are read there")


@pytest.mark.parametrize("q", [(0.0, 0.0), (0.7, -1.2), (3.0, 2.0)])
def test_the_chain_has_the_published_equations(q: tuple[float, float]) -> None:
    """M and gravity of model 1.0 as docs/text/dynamics.rst prints them.

    Terms of the rotors riding on their links (Ir and gr Ir beside gr^2 Ir) are left out: 0.5 % of M12 and less.
    """
    links = fd.LinkSide(fd.load_model(HERE / "frictionless.yaml"))
    M = links.mass_matrix(np.array([q]))[0]
    M22, b = I2 + GR**2 * IR, LENGTH * M2 * R2 * np.cos(q[1])
    expected = [[I1 + I2 + LENGTH**2 * M2 + 2 * b + GR**2 * IR, I2 + b], [I2 + b, M22]]
    np.testing.assert_allclose(M, expected, rtol=1e-3)
    both = G * M2 * R2 * np.sin(q[0] + q[1])
    weight = [G * (M1 * R1 + M2 * LENGTH) * np.sin(q[0]) + both, both]
    np.testing.assert_allclose(links.bias(np.array([q]), np.zeros((1, 2)))[0], weight, rtol=1e-3, atol=1e-6)


@needs_data
def test_published_friction_predicts_better_than_none() -> None:
    """Windows of 0.5 s on the excitation record: about 0.15 and 0.26 rad without friction, a sixth of it with."""
    record = read_records(DATA)["143524"]
    start = fd.load_model(HERE / "frictionless.yaml")
    without, friction = (windows(model, record).rms for model in (start, published(start)))
    np.testing.assert_allclose(without, [0.149, 0.259], rtol=0.05)
    assert (friction < 0.25 * without).all()
