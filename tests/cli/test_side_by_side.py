"""Files side by side, trimming and blocks kept apart, on the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.cli.options import span_of
from flexdyn.errors import InputError
from tests.cli.conftest import Runner

T = np.arange(0.0, 2.0, 0.01)


def test_files_with_a_plus_between_them(flexdyn: Runner) -> None:
    """Files with a plus between them, each with its map; the alignment is told."""
    fd.write_recording(fd.Recording(T, {"q.a": np.sin(T)}), "positions.csv")
    Path("currents.csv").write_text(
        "zeit,i\n" + "".join(f"{k * 0.004:.3f},{k * 0.02:.2f}\n" for k in range(400)), encoding="utf-8"
    )
    Path("p.yaml").write_text("{flexdyn_map: 1, channels: {q.a: q.a}}", encoding="utf-8")
    Path("c.yaml").write_text("{flexdyn_map: 1, time: zeit, channels: {tau.a: i}}", encoding="utf-8")
    outcome = flexdyn("plot", "positions.csv+currents.csv", "--map", "p.yaml+c.yaml", "-o", "both.png")
    assert outcome.code == 0
    assert "currents (250 Hz) was put on the times of positions (100 Hz)" in outcome.err
    outcome = flexdyn("plot", "positions.csv+currents.csv+positions.csv", "--map", "p.yaml+c.yaml", "-o", "both.png")
    assert outcome.code == 2
    assert "2 maps for 3 files side by side" in outcome.err
    assert "gone.csv: no such file" in flexdyn("plot", "positions.csv+gone.csv", "-o", "both.png").err


@pytest.mark.parametrize(("text", "span"), [("1:2.5", (1.0, 2.5)), (":3", (None, 3.0)), ("0.5:", (0.5, None))])
def test_spans(text: str, span: tuple[float | None, float | None]) -> None:
    """Either end may be left out."""
    assert span_of("--trim", text) == span


@pytest.mark.parametrize("text", ["", ":", "1", "2:1", "1:1", "a:2", "1:2:3", "nan:2"])
def test_spans_that_are_none(text: str) -> None:
    """One line with the option."""
    with pytest.raises(InputError, match="--trim"):
        span_of("--trim", text)
