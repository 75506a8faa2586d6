"""What people see who work in a notebook: tables for what they made, short reprs, and public names on Tab."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import flexdyn as fd
from tests.batch.small import pulse_study
from tests.diagnose import report_cases

EVIL = "<img src=x onerror=alert(1)>"


@functools.cache
def run() -> fd.Run:
    """A second of the paper's arm."""
    return fd.simulate(fd.load_model("scara_two_link"), duration=1.0, v0=[0.4, -0.3])


def study(folder: Path) -> Any:
    """A small study's results."""
    return fd.run_study(pulse_study(folder, runs=4), out=folder / "out.zarr")


MADE: dict[str, tuple[Callable[[Path], Any], tuple[str, ...]]] = {
    "robot": (lambda _: fd.load_robot("panda"), ("Robot panda", "panda_joint1", "rad/s", "moving mass")),
    "model": (
        lambda _: fd.load_model("scara_two_link"),
        ("FlexibleJointModel scara_two_link", "shoulder", "elastic", "5.5", "viscous_friction", "coefficient 0.01"),
    ),
    "run": (lambda _: run(), ("Run of scara_two_link", "DormandPrince", "elbow", "1.571", "deflection")),
    "recording": (lambda _: run().to_recording(), ("Recording scara_two_link", "1001", "q.elbow", "rad/s", "tau_s")),
    "diagnosis": (
        lambda _: report_cases.robot(),
        ("partly_explained", "torque error", "probability", "writes report.html"),
    ),
    "study": (study, ("Study of", "4, 0 failed", "joints.lift.stiffness", "residual_vibration", "median")),
    "comparison": (lambda _: fd.compare(run(), run()), ("Comparison", "q.shoulder", "RMS")),
}


@pytest.mark.parametrize("kind", MADE)
def test_a_notebook_shows_a_table(kind: str, tmp_path: Path) -> None:
    """Well-formed HTML with the numbers that one looks for first; no script, no link."""
    make, words = MADE[kind]
    html = make(tmp_path)._repr_html_()
    ElementTree.fromstring(html)  # noqa: S314 - our own
    text = re.sub(r"<[^>]+>", " ", html)
    for word in words:
        assert word in text, (word, text)
    assert not re.search(r"<script|href=|src=|http", html)
    assert len(html) < 60_000


@pytest.mark.parametrize("kind", MADE)
def test_a_plain_repr_is_short(kind: str, tmp_path: Path) -> None:
    """Five lines at most, and not a page each."""
    text = repr(MADE[kind][0](tmp_path))
    assert len(text.splitlines()) <= 5
    assert 20 < len(text) < 400


def test_other_objects_are_short_too() -> None:
    """Those that hold arrays or pictures."""
    for made in (run().energy, run().plot(), fd.Samples(np.arange(5000), np.zeros((5000, 2)))):
        assert len(repr(made).splitlines()) == 1
        assert len(repr(made)) < 200
    assert "5000 by 2" in repr(fd.Samples(np.arange(5000), np.zeros((5000, 2))))


def test_names_are_text_in_a_table() -> None:
    """Channels and files of any origin."""
    html = fd.Recording([0.0, 1.0], {f"q.{EVIL}": [0.0, 1.0]}, name=EVIL)._repr_html_()
    assert "<img" not in html
    assert "&lt;img" in html


def test_long_tables_are_counted() -> None:
    """Twenty rows, and how many more."""
    rec = fd.Recording([0.0, 1.0], {f"q.j{k}": [0.0, 1.0] for k in range(50)})
    html = rec._repr_html_()
    assert html.count("<tr>") == 21
    assert "and 30 more" in html


@pytest.mark.parametrize("module", [fd, fd.effects, fd.solvers])
def test_tab_offers_public_names_of_modules(module: Any) -> None:
    """Neither the packages below nor what a module imported; all that it promises is there."""
    offered = set(dir(module)) - {"__version__"}
    assert offered == set(module.__all__)
    assert all(hasattr(module, name) for name in offered)


@pytest.mark.parametrize("kind", MADE)
def test_tab_offers_public_names_of_objects(kind: str, tmp_path: Path) -> None:
    """No underscore in front; attributes and methods are there."""
    made = MADE[kind][0](tmp_path)
    names = dir(made)
    assert names
    assert not [name for name in names if name.startswith("_")]
    wanted = {"robot": "tip", "model": "replace", "run": "energy", "recording": "resample", "diagnosis": "save"}
    assert wanted.get(kind, "plot") in names
