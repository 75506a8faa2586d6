"""Channels computed from others in a map: NumPy is the other hand; anything beyond sums and products is refused."""

from __future__ import annotations

import numpy as np
import pytest

from flexdyn.errors import InputError
from flexdyn.records.channelmap.expression import expression_of
from tests.records.mapping import channel_map, mapped

A, B = np.array([0.5, -1.5, 2.0]), np.array([3.0, 0.25, -4.0])
CHANNELS = {"a": A, "b": B, "q.elbow": A - B, "Ist A1": 2.0 * A}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a + b", A + B),
        ("a - b - a", A - B - A),
        ("a - (b - a)", A - (B - A)),
        ("2*a + b/4", 2 * A + B / 4),
        ("-a * -b", A * B),
        ("a / b / 2", A / B / 2),
        ("a / (b * 2)", A / (B * 2)),
        ("+.5e1*(a)", 5.0 * A),
        ("q.elbow+'Ist A1'", 3.0 * A - B),
        ("1e-3 - a*b + 2", 1e-3 - A * B + 2),
        ("+".join(["a"] * 400), 400 * A),
        ("007 * a", 7 * A),
        ("a - " * 40 + "a", -39 * A),
    ],
)
def test_values_are_those_of_numpy(text: str, expected: np.ndarray) -> None:
    """Products before sums, from the left, brackets first."""
    np.testing.assert_allclose(expression_of(text, "computed.x").value(CHANNELS), expected, rtol=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "a +", "a b", "(a", "a)", "a ** 2", "a // b", "a % b", "a; b", "sin(a)", "a[0]", "__import__('os')",
        "a = b", "'open", "1 + 2", "2 a", "lambda: a", "a if b else a", "(" * 400 + "a" + ")" * 400, "-" * 60 + "a",
        "-" * 990 + "a", "()", "a()", "(a, b)",
        "a" * 2000,
        "a\\x00", 3, None, ["a"],
    ],
)  # fmt: skip
def test_anything_else_is_refused(text: object) -> None:
    """In one line with the key; nothing is executed."""
    with pytest.raises(InputError, match=r"computed\.x") as caught:
        expression_of(text, "computed.x").value(CHANNELS)
    assert "\n" not in str(caught.value)


def test_a_map_computes_channels_of_channels() -> None:
    """Of SI values, after delays and gears, also of channels computed before; to_dict takes it back."""
    raw = {"t": [0.0, 0.1, 0.2], "alpha": [10.0, 20.0, 30.0], "beta": [1.0, 1.5, 2.0]}
    channels = {"q.elbow": {"from": "alpha", "unit": "deg"}, "twist": "beta"}
    computed = {"theta.elbow": "q.elbow + twist", "double": "2 * theta.elbow"}
    rec = mapped(raw, channels=channels, computed=computed)
    np.testing.assert_allclose(rec["theta.elbow"], np.deg2rad(raw["alpha"]) + raw["beta"], rtol=1e-15)
    np.testing.assert_allclose(rec["double"], 2.0 * rec["theta.elbow"], rtol=1e-15)
    assert rec.joints == ("elbow",)
    made = channel_map(channels=channels, computed=computed)
    assert made.to_dict()["computed"] == computed
    assert type(made).from_dict(made.to_dict()) == made


def test_a_computed_channel_of_a_sliding_joint_is_in_metres() -> None:
    """As the joint's other channels say."""
    raw = {"t": [0.0, 0.1], "x": [10.0, 20.0]}
    rec = mapped(raw, channels={"q.lift": {"from": "x", "unit": "mm"}}, computed={"theta.lift": "1.01 * q.lift"})
    assert rec.unit("theta.lift") == "m"


@pytest.mark.parametrize(
    ("computed", "match"),
    [
        ({"theta.elbow": "q.elbo"}, r"computed\.theta\.elbow.*no such channel.*did you mean 'q\.elbow'"),
        ({"x": "y", "y": "q.elbow"}, r"computed\.x.*no such channel"),
        ({"q.elbow": "2 * q.elbow"}, r"computed\.q\.elbow.*there already"),
        ({"Theta.elbow": "q.elbow"}, r"computed\.Theta\.elbow.*did you mean 'theta'"),
        ({"t": "q.elbow"}, r"computed: "),
        ({"x": "t"}, r"computed\.x.*no such channel"),
    ],
)
def test_mistakes_in_a_map(computed: dict[str, str], match: str) -> None:
    """One line that names key and remedy."""
    with pytest.raises(InputError, match=match):
        channel_map(channels={"q.elbow": "alpha"}, computed=computed)


def test_a_quotient_by_zero_is_no_number() -> None:
    """Refused with its row, as any gap is."""
    raw = {"t": [0.0, 0.1], "x": [1.0, 0.0]}
    with pytest.raises(InputError, match=r"y: row 1: not a finite number"):
        mapped(raw, channels={"x": "x"}, computed={"y": "1 / x"})


def test_columns_that_are_kept_can_be_used() -> None:
    """With others: keep, names of the file stand in expressions too."""
    rec = mapped({"t": [0.0, 0.1], "x": [1.0, 2.0]}, others="keep", computed={"q.a": "x / 2"})
    np.testing.assert_array_equal(rec["q.a"], [0.5, 1.0])
    with pytest.raises(InputError, match=r"computed\.q\.a.*no such channel"):
        mapped({"t": [0.0, 0.1], "x": [1.0, 2.0]}, others="keep", computed={"q.a": "y / 2"})
