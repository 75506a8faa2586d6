"""flexdyn effects: the catalogue in words, in JSON and in pictures."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.plots import EXAMPLES, SUFFIXES, draw_law, example_entry, example_values
from tests.cli.conftest import Runner

NAMES = tuple(fd.effects.catalogue())
DRAWN = tuple(name for name in NAMES if name != "payload")
MAGIC = {".png": b"\x89PNG\r\n", ".pdf": b"%PDF-", ".svg": b"<?xml"}


def test_the_table_names_every_effect(flexdyn: Runner) -> None:
    """All effects of the catalogue with law and units."""
    out = flexdyn("effects").out
    assert all(name in out for name in NAMES)
    assert "coefficient [N m s/rad]" in out
    assert "exponent [1] = 1" in out


@pytest.mark.parametrize("name", NAMES)
def test_a_page_holds_law_parameters_and_an_entry_that_loads(flexdyn: Runner, name: str) -> None:
    """Everything needed to use the effect; the example entry makes one."""
    kind = fd.effects.catalogue()[name]
    page = " ".join(flexdyn("effects", name).out.split())
    assert kind.law in page
    assert all(f"{field.name} {field.metadata['unit']}" in page for field in kind.parameters())
    found = flexdyn("effects", name, "--json").json
    assert fd.effects.effect_from_dict(found["example"]).name == name
    assert found["law"] == kind.law
    assert flexdyn("effects", kind.__name__, "--json").json == found


def test_json_of_all_effects(flexdyn: Runner) -> None:
    """A list in the catalogue's order; a limit that is infinite where it does nothing is null."""
    found = flexdyn("effects", "--json").json
    assert [entry["effect"] for entry in found] == list(NAMES)
    limit = next(entry for entry in found if entry["effect"] == "torque_speed_limit")
    assert limit["neutral"] == {"stall_torque": None}
    assert next(entry for entry in found if entry["effect"] == "payload")["names"] == ["frame"]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_formats_of_pictures(flexdyn: Runner, suffix: str) -> None:
    """The suffix chooses the format, in any case; nothing else is left in the folder."""
    path = Path(f"law{suffix.upper()}")
    assert flexdyn("effects", "viscous_friction", "-o", path).code == 0
    assert path.read_bytes().startswith(MAGIC[suffix])
    assert list(Path().iterdir()) == [path]


@pytest.mark.parametrize("name", DRAWN)
def test_every_law_can_be_drawn(tmp_path: Path, name: str) -> None:
    """Each picture carries the effect's name and the units of its axes."""
    draw_law(fd.effects.catalogue()[name], tmp_path / "law.svg")
    comments = " ".join(re.findall(r"<!-- (.*?) -->", (tmp_path / "law.svg").read_text(encoding="utf-8")))
    assert name.replace("_", " ").capitalize() in comments
    assert "[rad/s]" in comments
    assert "[N m]" in comments


@pytest.mark.parametrize("name", ["coulomb_friction", "stribeck_friction"])
def test_dry_laws_are_drawn_set_valued(tmp_path: Path, name: str) -> None:
    """At u = 0 stands a vertical line, as long as the two ends of the set are apart."""
    kind = fd.effects.catalogue()[name]
    draw_law(kind, tmp_path / "law.svg")
    lines = _lines(tmp_path / "law.svg")
    (rest,) = [line for colour, line in lines if colour == "#c23b22" and np.ptp(line[:, 0]) == 0.0]
    branches = [line for colour, line in lines if colour == "#1f4e9c"]
    left, right = sorted(branches, key=lambda line: float(line[:, 0].mean()))
    ends = sorted([left[np.argmax(left[:, 0]), 1], right[np.argmin(right[:, 0]), 1]])
    np.testing.assert_allclose(sorted(rest[:, 1]), ends, atol=1e-3)
    assert ends[1] - ends[0] > 50.0


def test_the_limit_is_drawn_as_it_acts(tmp_path: Path) -> None:
    """Asked for more than the stall torque, the motor gives less and less up to the no-load speed, then nothing."""
    draw_law(fd.effects.TorqueSpeedLimit, tmp_path / "law.svg")
    blue = [line for colour, line in _lines(tmp_path / "law.svg") if colour == "#1f4e9c"]
    (curve,) = [line for line in blue if np.ptp(line[:, 1]) > 0.0]  # the other one is the torque asked for
    flat = [line for line in blue if np.ptp(line[:, 1]) == 0.0]
    asked = max(flat, key=lambda line: float(np.ptp(line[:, 0])))  # the short one stands in the legend
    assert curve[0, 1] == pytest.approx(asked[0, 1], abs=1e-3)
    assert (np.diff(curve[:, 1]) >= -1e-6).all()  # an SVG counts downwards
    assert np.ptp(curve[:, 1]) > 50.0


def test_a_users_own_effect_is_drawn_too(tmp_path: Path) -> None:
    """A law in Python, of which flexdyn knows the units alone."""
    script = f"""
import flexdyn as fd, numpy as np
from flexdyn.plots import draw_law
class SquareRootDrag(fd.effects.JointEffect):
    '''Drag that grows as the root of speed.'''
    sides = ("link",)
    stage = "friction"
    law = "coefficient*sign(u)*sqrt(abs(u))"
    coefficient: float = fd.effects.parameter("N m s/rad", lower=0.0)
    def torque(self, x, u, *, t=0.0, tau=0.0):
        return self.coefficient*np.sign(u)*np.sqrt(np.abs(u))
draw_law(SquareRootDrag, {str(tmp_path / "law.svg")!r})
"""
    subprocess.run([sys.executable, "-c", script], check=True)
    assert "Square root drag" in (tmp_path / "law.svg").read_text(encoding="utf-8")


def test_a_picture_without_matplotlib_names_the_extra(flexdyn: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    """One line with the command that installs it, and no file."""
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    outcome = flexdyn("effects", "viscous_friction", "-o", "law.png")
    assert outcome.code == 2
    assert outcome.err == "flexdyn: matplotlib is not installed; install it with: pip install 'flexdyn[plot]'\n"
    assert not list(Path().iterdir())


@pytest.mark.parametrize("name", NAMES)
def test_examples_do_something(name: str) -> None:
    """No example is neutral, and every known example is of an effect that exists."""
    kind = fd.effects.catalogue()[name]
    assert not fd.effects.effect_from_dict(example_entry(kind, "elbow")).is_neutral
    assert set(EXAMPLES) <= set(NAMES)
    assert set(EXAMPLES.get(name, {})) <= set(example_values(kind))


def _lines(path: Path) -> list[tuple[str, np.ndarray]]:
    """Colour and points of every line in an SVG of matplotlib."""
    text = path.read_text(encoding="utf-8")
    found = []
    for data, style in re.findall(r'<path d="([^"]*)"[^>]*style="([^"]*)"', text):
        colour = re.search(r"stroke: (#[0-9a-f]{6})", style)
        numbers = [float(number) for number in re.findall(r"-?\d+\.?\d*", data)]
        if colour and "fill: none" in style and set(re.findall("[A-Za-z]", data)) <= {"M", "L"}:
            found.append((colour[1], np.array(numbers).reshape(-1, 2)))
    return found
