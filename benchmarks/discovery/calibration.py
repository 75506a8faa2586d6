"""Whether findings that are said to hold with some probability hold that often."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

EDGES = (0.0, 0.01, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)
"""Bins of probability, finer towards nothing and one, where most candidates are; each holds its upper edge."""


def reliability(claims: Iterable[tuple[float, bool]]) -> dict[str, Any]:
    """Reliability curve and expected calibration error.

    The error is the mean over bins, weighted by their counts, of abs(fraction that is true - mean probability).

    Args:
        claims: probability of a finding, and whether it is true.
    """
    pairs = list(claims)
    probability = np.array([p for p, _ in pairs], dtype=float)
    truth = np.array([t for _, t in pairs], dtype=float)
    place = np.clip(np.searchsorted(EDGES, probability, side="left") - 1, 0, len(EDGES) - 2)
    bins, error = [], 0.0
    for k, (low, high) in enumerate(pairwise(EDGES)):
        mine = place == k
        if not mine.any():
            continue
        mean, fraction = float(probability[mine].mean()), float(truth[mine].mean())
        bins.append({"from": low, "to": high, "count": int(mine.sum()), "probability": mean, "true": fraction})
        error += float(mine.mean()) * abs(fraction - mean)
    return {"findings": len(pairs), "bins": bins, "calibration_error": error if pairs else None}


def claims_of(rows: Sequence[dict[str, Any]]) -> list[tuple[float, bool]]:
    """All findings of scored cases that carry a probability."""
    claims = [claim for row in rows for claim in row.get("claims", [])]
    return [(float(c["probability"]), bool(c["true"])) for c in claims if c["probability"] is not None]


def candidates_of(rows: Sequence[dict[str, Any]]) -> list[tuple[float, bool]]:
    """All candidates that the reports list, named or not, with their posterior probabilities."""
    return [(float(p), bool(true)) for row in rows for p, true in row.get("candidates", [])]


def table(found: dict[str, Any]) -> str:
    """For the terminal."""
    if not found["findings"]:
        return "no finding carries a probability"
    lines = [f"{'probability':>16s}{'findings':>10s}{'mean':>8s}{'true':>8s}"]
    for row in found["bins"]:
        span = f"{row['from']:g} to {row['to']:g}"
        lines.append(f"{span:>16s}{row['count']:>10d}{row['probability']:>8.3f}{row['true']:>8.3f}")
    return "\n".join([*lines, f"expected calibration error: {found['calibration_error']:.3f}"])
