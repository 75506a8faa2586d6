"""Two estimates of the same noise: `estimate_noise` of all of it, `reading_noise` of what changes between samples.

On a simulated carriage with dry friction, whose encoder gets noise of a known kind, and on the encoders of measured
robots. The diagnosis differentiates positions twice and takes their errors as independent from sample to sample. What
its rows need is therefore the white noise that has the same power where a second derivative has its weight.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from measure import Contestant, arguments, conclude, race
from numpy.typing import NDArray

import flexdyn as fd
from flexdyn.records.signals.kernels import GaussianSmoother
from flexdyn.records.signals.reading_noise import reading_noise

Array = NDArray[np.float64]
HERE = Path(__file__).parent / "measured"
RATE, SECONDS, SEEDS = 1000.0, 10.0, 40
SIZE = 1e-5
"""Standard deviation of the noise that is added [m]."""
MEMORY = 0.9
"""Correlation from sample to sample of the noise with memory, as a filter in the encoder's electronics makes it [1]."""
ROUNDS = 30
WIDTH = 0.005
"""Standard deviation of the narrowest second filter of the diagnosis [s]."""
RECORDS = {
    "EMPS": ("emps/map.yaml", "emps/DATA_EMPS.mat"),
    "double pendulum": ("double_pendulum/map.yaml", "dfki_double_pendulum/20230629-143601.csv"),
    "XL330": ("xl330/map.yaml", "bam_xl330/xl330_kp400_sin_sin.csv"),
    "KUKA KR 300": ("kuka_kr300/map.yaml", "kuka_kr300/recorded_A.mat"),
}
"""Robot -> its channel map and one of its recordings."""


def carriage(level: float) -> fd.FlexibleJointModel:
    """The carriage of EMPS as a rigid axis with dry friction of this level [N]."""
    friction = fd.effects.CoulombFriction("carriage", side="motor", level=level)
    return fd.load_model(HERE / "emps" / "plain.yaml").replace(effects=[friction])


def motion(level: float) -> fd.Run:
    """The carriage under a controller that follows two sines: it reverses two to four times a second."""
    t = np.arange(round(SECONDS * RATE)) / RATE
    wanted = 0.08 * np.sin(2.0 * np.pi * 0.7 * t) + 0.03 * np.sin(2.0 * np.pi * 1.9 * t)
    servo = fd.Servo(
        reference=fd.Samples(t, wanted, "linear"), position_gain=40.0, velocity_gain=8e3, span=0, speed_feedforward=1.0
    )
    return fd.simulate(carriage(level), servo, t[-1], rate=RATE, v0=[(wanted[1] - wanted[0]) * RATE])


def white(random: np.random.Generator, q: Array) -> Array:
    """Independent Gaussian errors."""
    return random.normal(0.0, SIZE, len(q))


def with_memory(random: np.random.Generator, q: Array) -> Array:
    """A first-order autoregression of the same standard deviation."""
    from scipy.signal import lfilter

    whole = lfilter([np.sqrt(1.0 - MEMORY**2)], [1.0, -MEMORY], random.normal(0.0, SIZE, len(q) + 200))
    return np.asarray(whole[200:])


def rounded(random: np.random.Generator, q: Array) -> Array:
    """Counts of an encoder: a step whose rounding has the same standard deviation, from a random zero."""
    step = SIZE * np.sqrt(12.0)
    zero = random.uniform(0.0, step)
    return np.asarray(step * np.round((q + zero) / step) - zero - q)


KINDS: Mapping[str, Callable[[np.random.Generator, Array], Array]] = {
    "white": white,
    "with memory": with_memory,
    "rounded to counts": rounded,
}


def of_kind(q: Array, kind: str) -> dict[str, Any]:
    """Both estimates over the true standard deviation, and the error of an acceleration over what each predicts."""
    t = np.arange(len(q)) / RATE
    smoother = GaussianSmoother.of_width(WIDTH, 1.0 / RATE)
    gain = float(np.linalg.norm(smoother.taps[2]))
    rows = []
    for seed in range(SEEDS):
        error = KINDS[kind](np.random.default_rng(seed), q)
        whole, reading = fd.estimate_noise(t, q + error).std, reading_noise(q + error)
        std, acceleration = float(np.std(error)), float(np.std(smoother.apply(error, 2)))
        rows.append((whole / std, reading / std, acceleration / (gain * whole), acceleration / (gain * reading)))
    low, middle, high = np.percentile(rows, [5, 50, 95], axis=0).round(3).tolist()
    keys = ("whole_over_true", "reading_over_true", "acceleration_over_whole", "acceleration_over_reading")
    return {key: {"median": middle[k], "p5": low[k], "p95": high[k]} for k, key in enumerate(keys)}


def recorded(folder: Path) -> dict[str, Any]:
    """Both estimates for every encoder of a recording of each robot."""
    found: dict[str, Any] = {}
    for robot, (ready, file) in RECORDS.items():
        recording = fd.read_recording(folder / file, map=HERE / ready)
        channels = [name for name in recording.channels if name.split(".")[0] in ("q", "theta")]
        noise = {name: recording.noise(name) for name in channels}
        found[robot] = {
            name: {"unit": each.unit, "std": each.std, "reading_std": each.reading_std, "step": each.step}
            for name, each in noise.items()
        }
    return found


def main() -> int:
    """Measure, print and write."""
    parser = arguments(__doc__)
    parser.add_argument("data", type=Path, help="folder of the measured robots' data")
    given = parser.parse_args()
    motions = {"smooth motion": motion(0.0).q[:, 0], "dry friction": motion(20.3).q[:, 0]}
    simulated = {f"{kind}, {name}": of_kind(q, kind) for name, q in motions.items() for kind in KINDS}
    q = motions["dry friction"] + white(np.random.default_rng(0), motions["dry friction"])
    t = np.arange(len(q)) / RATE
    contestants = [
        Contestant("estimate_noise", lambda: fd.estimate_noise(t, q)),
        Contestant("reading_noise", lambda: reading_noise(q)),
    ]
    times = race(contestants, ROUNDS)
    content = {
        "simulated": simulated,
        "recorded": recorded(given.data),
        "milliseconds": {name: round(1e3 * float(np.median(each)), 3) for name, each in times.items()},
        "samples": len(q),
        "seeds": SEEDS,
    }
    return conclude([], given.output, "noise_estimators.py DATA", content)


if __name__ == "__main__":
    sys.exit(main())
