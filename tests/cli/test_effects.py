"""flexdyn effects: the catalogue in words, in JSON and in pictures."""

from __future__ import annotations

import html
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.plots import SUFFIXES, draw_law, example_entry
from flexdyn.plots.laws import law_figure
from tests.cli.conftest import Runner

NAMES = tuple(fd.effects.catalogue())
OVER_TORQUE = ("torque_offset", "torque_constant_error", "torque_saturation")
OVER_TIME = ("command_delay", "channel_lag")
OVER_POSITION = (
    *("position_dependent_friction", "presliding_friction", "joint_elasticity", "hardening_spring", "backlash"),
    *("spring_hysteresis", "kinematic_error", "torque_ripple", "parallel_spring", "position_torque", "end_stop"),
    *("encoder_eccentricity", "sensor_offset", "sensor_gain", "payload", "parameter_error"),
)
BLUE, RED = "#1f4e9c", "#c23b22"
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


@pytest.mark.parametrize("name", NAMES)
def test_every_law_can_be_drawn(tmp_path: Path, name: str) -> None:
    """Each picture carries the effect's name and law, what it is drawn over, and the units of its axes."""
    kind = fd.effects.catalogue()[name]
    draw_law(kind, tmp_path / "law.svg")
    texts = _texts(tmp_path / "law.svg")
    assert name.replace("_", " ").capitalize() in texts
    assert kind.law in texts
    over_torque = name in OVER_TORQUE or kind.takes_load
    across = "[N m]" if over_torque else "[s]" if name in OVER_TIME else "[rad]" if name in OVER_POSITION else "[rad/s]"
    is_length = kind.stage in ("sensor", "deflection")
    labels = [text for text in texts if text.endswith(("[N m]", "[s]", "[rad]", "[rad/s]"))]
    assert [label[label.rindex("[") :] for label in labels] == [across, "[rad]" if is_length else "[N m]"]


def test_an_effect_without_a_law_says_so(tmp_path: Path) -> None:
    """A user's law that acts on no joint: what it does instead stands in the error, and no file is left."""

    class Wind(fd.effects.Effect, abstract=True):
        name = "wind"
        no_torque = "it pushes the whole arm"

    with pytest.raises(fd.InputError, match="the effect has no law to draw, got 'wind'; it pushes the whole arm"):
        draw_law(Wind, tmp_path / "law.png")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("effect", "extra"),
    [
        (fd.effects.Payload(mass=1.0), (0.5 * 9.81, 0.25 * 15.0)),
        (fd.effects.Payload(mass=1.0, frame="joint"), (0.0, 0.0)),
        (fd.effects.ParameterError("elbow", parameter="rotor_inertia", factor=1.5), (0.0, 0.1 * 15.0)),
        (fd.effects.ParameterError("rod", parameter="link_mass", factor=1.5), (0.5 * 0.5 * 9.81, 0.5 * 0.125 * 15.0)),
    ],
)
def test_what_changes_the_arm_is_drawn_by_its_torque(effect: fd.effects.Effect, extra: tuple[float, float]) -> None:
    """Weight at the horizontal rod, and the torque of acceleration beside it, as by hand: 0.5 m, 2 kg, 0.2 kg m^2."""
    (axes,) = law_figure(effect).axes
    curves = {
        (line.get_color(), line.get_linestyle()): line.get_xydata() for line in axes.lines if len(line.get_xdata()) > 2
    }
    weight, both = (
        [float(np.interp(0.5 * np.pi, *curves[shade, look].T)) for look in ("-", "--")] for shade in (BLUE, RED)
    )
    assert weight[0] - weight[1] == pytest.approx(extra[0], abs=1e-3)
    assert both[0] - both[1] - (weight[0] - weight[1]) == pytest.approx(extra[1], abs=1e-3)


def test_an_error_of_a_number_that_the_drawn_arm_lacks_is_refused() -> None:
    """A rigid joint has no stiffness."""
    with pytest.raises(fd.InputError, match="stiffness"):
        law_figure(fd.effects.ParameterError("elbow", parameter="stiffness", factor=1.5))


@pytest.mark.parametrize("name", ["presliding_friction", "spring_hysteresis"])
def test_memory_is_drawn_as_a_loop(tmp_path: Path, name: str) -> None:
    """Out and back, the torque at one position differs by twice the level, and going out it is the greater one."""
    draw_law(fd.effects.catalogue()[name], tmp_path / "law.svg")
    curve = max((line for colour, line in _lines(tmp_path / "law.svg") if colour == BLUE), key=len)
    middle = 0.5 * (curve[:, 0].min() + curve[:, 0].max())
    turn = int(np.argmin(curve[:, 0]))
    back, out = curve[:turn], curve[turn : turn + int(np.argmax(curve[turn:, 0]))]
    at_middle = [float(np.interp(middle, *line[np.argsort(line[:, 0])].T)) for line in (back, out)]
    height = float(np.ptp(curve[:, 1]))
    assert at_middle[0] - at_middle[1] > 0.9 * height  # an SVG counts downwards


def test_backlash_is_drawn_with_its_dead_zone(tmp_path: Path) -> None:
    """Flat over a third of the picture, which shows three half gaps on either side; of slope 1 elsewhere."""
    draw_law(fd.effects.Backlash, tmp_path / "law.svg")
    curve = max((line for colour, line in _lines(tmp_path / "law.svg") if colour == BLUE), key=len)
    flat = curve[np.abs(curve[:, 1] - np.median(curve[:, 1])) < 1e-3, 0]
    assert np.ptp(flat) / np.ptp(curve[:, 0]) == pytest.approx(1 / 3, abs=0.01)
    assert (np.diff(curve[:, 1]) <= 1e-6).all()


@pytest.mark.parametrize(("harmonic", "waves"), [(2.0, 2), (40.0, 8), (222.0, 8)])
def test_as_many_waves_are_drawn_as_can_be_told_apart(harmonic: float, waves: int) -> None:
    """All of a turn, or a part of it; also of harmonics that a coarse grid takes for none."""
    effect = fd.effects.KinematicError("elbow", amplitude=1e-4, harmonic=harmonic, phase=0.3)
    (line,) = [each for each in law_figure(effect).axes[0].lines if each.get_color() == BLUE]
    y = line.get_ydata()
    assert np.abs(y).max() == pytest.approx(1e-4, rel=1e-2)
    assert (np.diff(np.sign(y)) > 0.0).sum() == waves


@pytest.mark.parametrize("name", ["load_dependent_friction", "position_dependent_friction"])
def test_levels_that_vary_are_drawn_as_a_band(tmp_path: Path, name: str) -> None:
    """The two directions mirror each other, and the set at rest lies between them."""
    draw_law(fd.effects.catalogue()[name], tmp_path / "law.svg")
    lines = _lines(tmp_path / "law.svg")
    forwards, backwards = (max((line for colour, line in lines if colour == own), key=len) for own in (BLUE, RED))
    middle = 0.5 * (forwards[:, 1] + np.interp(forwards[:, 0], *backwards.T))
    assert np.ptp(middle) < 0.2
    assert forwards[:, 1].max() <= backwards[:, 1].min() + 0.2
    assert "at rest: any of these" in _texts(tmp_path / "law.svg")


def test_a_delay_is_drawn_as_a_step_that_comes_late(tmp_path: Path) -> None:
    """Two equal steps; the second one rises later by a quarter of what is shown after the first."""
    draw_law(fd.effects.CommandDelay, tmp_path / "law.svg")
    lines = _lines(tmp_path / "law.svg")
    (asked,) = [line for colour, line in lines if colour == "#6b7280" and np.ptp(line[:, 1]) > 50]
    (given,) = [line for colour, line in lines if colour == BLUE and np.ptp(line[:, 1]) > 50]
    rises = [float(line[np.argmax(np.abs(np.diff(line[:, 1]))), 0]) for line in (asked, given)]
    assert (rises[1] - rises[0]) / (asked[-1, 0] - rises[0]) == pytest.approx(0.25, abs=1e-3)
    assert sorted(set(asked[:, 1])) == pytest.approx(sorted(set(given[:, 1])))


@pytest.mark.parametrize("name", ["coulomb_friction", "asymmetric_friction", "stribeck_friction"])
def test_dry_laws_are_drawn_set_valued(tmp_path: Path, name: str) -> None:
    """At u = 0 stands a vertical line, as long as the two ends of the set are apart."""
    kind = fd.effects.catalogue()[name]
    draw_law(kind, tmp_path / "law.svg")
    lines = _lines(tmp_path / "law.svg")
    (rest,) = [line for colour, line in lines if colour == RED and np.ptp(line[:, 0]) == 0.0]
    branches = [line for colour, line in lines if colour == BLUE]
    left, right = sorted(branches, key=lambda line: float(line[:, 0].mean()))
    ends = sorted([left[np.argmax(left[:, 0]), 1], right[np.argmin(right[:, 0]), 1]])
    np.testing.assert_allclose(sorted(rest[:, 1]), ends, atol=1e-3)
    assert ends[1] - ends[0] > 50.0


def test_the_limit_is_drawn_as_it_acts(tmp_path: Path) -> None:
    """Asked for more than the stall torque, the motor gives less and less up to the no-load speed, then nothing."""
    draw_law(fd.effects.TorqueSpeedLimit, tmp_path / "law.svg")
    blue = [line for colour, line in _lines(tmp_path / "law.svg") if colour == BLUE]
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
    """No example is neutral; it acts on the joint that is asked for, on the motor where it has the choice."""
    entry = example_entry(fd.effects.catalogue()[name], "elbow", "wrist")
    effect = fd.effects.effect_from_dict(entry)
    assert not effect.is_neutral
    assert entry.get("joint", entry.get("of", entry.get("channel", "elbow"))) in ("elbow", "q.elbow")
    assert entry.get("other", "wrist") == "wrist"
    assert "link" not in effect.sides or entry["side"] == effect.sides[-1]


def _texts(path: Path) -> list[str]:
    """Every text in an SVG of matplotlib, in order."""
    return [html.unescape(text) for text in re.findall(r"<!-- (.*?) -->", path.read_text(encoding="utf-8"))]


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
