"""Reliability of probabilities: bins, fractions, expected calibration error."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from calibration import candidates_of, claims_of, reliability, table


def test_the_error_is_the_weighted_mean_over_bins() -> None:
    """Eight of ten true at 0.85 are off by 0.05, all of ten true at 0.97 by 0.03."""
    claims = [(0.85, k < 8) for k in range(10)] + [(0.97, True)] * 10
    found = reliability(claims)
    assert found["calibration_error"] == pytest.approx(0.5 * 0.05 + 0.5 * 0.03)
    assert [(row["count"], row["true"]) for row in found["bins"]] == [(10, 0.8), (10, 1.0)]
    assert "expected calibration error: 0.040" in table(found)


def test_calibrated_probabilities_have_a_small_error_and_bold_ones_do_not() -> None:
    """Many claims that hold as often as they say, and the same ones said at 0.99."""
    rng = np.random.default_rng(0)
    honest = [(float(p), bool(rng.random() < p)) for p in rng.uniform(0.5, 1.0, 5000)]
    assert reliability(honest)["calibration_error"] < 0.02
    assert reliability([(0.99, true) for _, true in honest])["calibration_error"] > 0.2


def test_edges_belong_to_the_bin_below_and_nothing_said_is_nothing_counted() -> None:
    """Probabilities of zero and one have a bin; reports without probabilities have none."""
    found = reliability([(0.0, False), (0.5, True), (1.0, True)])
    assert [(row["from"], row["to"], row["count"]) for row in found["bins"]] == [
        (0.0, 0.01, 1),
        (0.3, 0.5, 1),
        (0.99, 1.0, 1),
    ]
    rows: list[dict[str, Any]] = [{"claims": [{"name": "x", "probability": None, "true": True}]}, {"points": 0.0}]
    assert reliability(claims_of(rows)) == {"findings": 0, "bins": [], "calibration_error": None}


def test_candidates_count_whether_or_not_they_are_named() -> None:
    """Of two cases, and of one without a report."""
    rows: list[dict[str, Any]] = [{"candidates": [[0.9, True], [0.1, False]]}, {"candidates": [[0.2, True]]}, {}]
    assert candidates_of(rows) == [(0.9, True), (0.1, False), (0.2, True)]
