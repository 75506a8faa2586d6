"""Slopes along the expected motion: the noise that they share with the residual is gone (errors in variables)."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import flexdyn as fd
from flexdyn.arrays import Array
from flexdyn.diagnose.data.measured import Measured, measured
from flexdyn.diagnose.equations.covariance import SampleNoise, whitener
from flexdyn.diagnose.equations.equations import Equations
from flexdyn.diagnose.equations.expected import expected_data, onto_samples
from flexdyn.diagnose.equations.mask import sign_mask
from flexdyn.diagnose.equations.noise_coefficients import coefficients
from flexdyn.diagnose.hypothesis.estimate import fit
from flexdyn.diagnose.hypothesis.fitted import Fit
from flexdyn.diagnose.hypothesis.linear import linearised, reached
from flexdyn.diagnose.hypothesis.number_columns import of_numbers
from flexdyn.diagnose.hypothesis.prepared import prepared
from flexdyn.diagnose.hypothesis.workspace import weighed
from flexdyn.diagnose.inference.weights import along_expected, for_fit
from flexdyn.model.uncertain_parameters import FileNumber, file_numbers

SOFT = {"shoulder": {"stiffness": 400.0, "damping": 0.8}, "elbow": {"stiffness": 900.0, "damping": 0.5}}
TORQUE_NOISE, ENCODER_NOISE = 0.5, 1e-7
DRAWS = 60


def _arm() -> fd.FlexibleJointModel:
    """Two soft joints."""
    joints = {name: {**numbers, "rotor_inertia": 4e-5} for name, numbers in SOFT.items()}
    return fd.load_model("scara_two_link").replace(joints=joints, effects=[], tolerance=0.1)


@pytest.fixture(scope="module")
def clean() -> tuple[Equations, SampleNoise]:
    """The equations of the true arm along a record without noise, with encoders on the motors alone."""
    model, t = _arm(), np.arange(1500) / 500
    turns = np.stack([0.5 * np.sin(3.0 * t) + 0.1 * np.sin(9.0 * t), 1.5 + 0.4 * np.sin(4.0 * t)], axis=1)
    run = fd.simulate(model, fd.PD(fd.Samples(t, turns, "cubic"), kp=300, kd=15), q0=turns[0])
    log = run.to_recording()
    seen = {f"{signal}.{joint}": log[f"{signal}.{joint}"] for joint in model.joint_names for signal in ("theta", "tau")}
    bare, _ = prepared(model, (measured(model, fd.Recording(run.t, seen)),))
    two = np.ones(2)
    return bare.equations, SampleNoise(0.0 * two, ENCODER_NOISE * two, TORQUE_NOISE * two, 0.0 * two)


def _noisy(data: Measured, noise: SampleNoise, rng: np.random.Generator) -> Measured:
    """The record with noise."""
    tau = data.tau + noise.tau * rng.normal(size=data.tau.shape)
    return dataclasses.replace(data, tau=tau, theta=data.theta + noise.theta * rng.normal(size=data.theta.shape))


@pytest.mark.parametrize("share", [0.0, 0.4])
def test_rows_say_of_samples_what_samples_do_to_rows(clean: tuple[Equations, SampleNoise], share: float) -> None:
    """``y . (A n) = (A^T y) . n`` for y = A n by computing the equations again, to a percent.

    Friction that takes a share of the load passes less of the torque's noise to the link where the motor drives it, and
    more where the link drives the motor.
    """
    at, noise = clean
    if share:
        lost = [fd.effects.LoadDependentFriction(j, side="motor", coefficient=share) for j in at.model.joint_names]
        at = at.of(at.model.replace(effects=[*at.model.effects, *lost]))
    rng, (data,), (along,) = np.random.default_rng(1), at.data, at.motions
    little = 1e-3 if share else 1.0  # so that no sign of a load changes
    moved = dataclasses.replace(data, tau=data.tau + little * noise.tau * rng.normal(size=data.tau.shape))
    change = dataclasses.replace(at, data=(moved,)).residual - at.residual
    y = change.reshape(-1, len(at.kinds)) * ~sign_mask(at, noise).reshape(-1, len(at.kinds))
    samples = along.lost + at.filters.instants(len(along.t))
    back = sum(
        float(onto_samples(at, channel, orders, y, samples, len(data.t)) @ (moved.tau - data.tau)[:, channel[1]])
        for channel, orders in coefficients(at, along).items()
        if channel[0] == "tau"
    )
    assert back == pytest.approx(float(np.sum(y**2)), rel=0.05 if share else 0.01)


@pytest.mark.parametrize("late", [5, -5])
def test_the_noise_of_a_late_channel_is_found_where_it_was_recorded(
    clean: tuple[Equations, SampleNoise], late: int
) -> None:
    """What is expected of white noise resembles it most at its own samples, however late a channel or a command is."""
    at, noise = clean
    (data,) = at.data
    recorded = dataclasses.replace(data, tau=np.roll(data.tau, late, axis=0))
    by = abs(late) * data.dt
    lags: list[fd.effects.Effect] = [
        fd.effects.ChannelLag(f"tau.{joint}", delay=by)
        if late > 0
        else fd.effects.CommandDelay(joint, side="motor", delay=by)
        for joint in at.model.joint_names
    ]
    n = noise.tau * np.random.default_rng(4).normal(size=data.tau.shape)
    noisy = dataclasses.replace(at, data=(dataclasses.replace(recorded, tau=recorded.tau + n),))
    here = noisy.of(at.model.replace(effects=[*at.model.effects, *lags]))
    white = whitener(here, noise, np.zeros(at.residual.size, bool))
    (found,) = expected_data(here, noise, white, np.ones(len(at.kinds)))
    seen = (recorded.tau + n - found.tau)[50:-50]
    alike = {k: float((seen * np.roll(n, k, axis=0)[50:-50]).sum()) for k in range(-10, 11)}
    likeliest = max(alike, key=lambda k: alike[k])
    assert abs(likeliest) <= 1  # the filters are several samples wide


def test_a_spring_that_the_file_lacks_has_the_slope_of_the_likelihood(clean: tuple[Equations, SampleNoise]) -> None:
    """The file says rigid, the hypothesis has springs: by differences of what a fit makes small, weights included."""
    (data,), noise = clean[0].data, clean[1]
    arm = fd.load_model("scara_two_link").replace(effects=[], tolerance=0.1)
    rigid = arm.replace(joints={name: {"rotor_inertia": 4e-5, "stiffness": np.inf} for name in SOFT})
    bare, here = prepared(rigid, (_noisy(data, noise, np.random.default_rng(5)),))
    springs = (fd.effects.JointElasticity(name, stiffness=each["stiffness"]) for name, each in SOFT.items())
    there = dataclasses.replace(here, effects=tuple(springs))
    at = bare.equations.of(there.model())
    bare = dataclasses.replace(bare, noise=noise, mask=np.zeros(at.residual.size, bool))
    work = for_fit(bare, there)
    on_record = dataclasses.replace(work.bare, along=None)
    step, first = 0.2, len(there.factors)
    slopes, along_the_record = (
        _slopes(linearised(there, each, at=at))[first:] for each in (work, dataclasses.replace(work, bare=on_record))
    )
    for k, (spring, scale) in enumerate(zip(there.effects, linearised(there, work, at=at).scales, strict=True)):
        sides = []
        for way in (step, -step):
            moved = spring.replace(stiffness=getattr(spring, "stiffness") + way * scale)  # noqa: B009 - an Effect has none
            other = dataclasses.replace(there, effects=tuple(moved if e is spring else e for e in there.effects))
            sides.append(reached(other, bare.equations.of(other.model()), work))
        true = (sides[0] - sides[1]) / (2.0 * step)
        assert abs(slopes[k] - true) < 0.25 * abs(along_the_record[k] - true)


def _slopes(made: Fit) -> Array:
    """Slopes of the sum of squares by numbers and unknowns, with the best offsets of the encoders."""
    problem = made.regression
    rows = np.vstack([problem.X, np.diag(1.0 / problem.sigma)])
    target = np.concatenate([problem.y, -problem.centre / problem.sigma])
    offsets = rows[:, rows.shape[1] - problem.nuisances :]
    left = target - offsets @ np.linalg.lstsq(offsets, target, rcond=None)[0]
    return np.asarray(2.0 * left @ rows)


def _log_determinant(at: Equations, noise: SampleNoise, number: FileNumber, factor: float) -> float:
    """log|C| of the rows where a number of the file has another factor."""
    model = at.model.replace(effects=[*at.model.effects, number.error(factor)])
    whole = whitener(at.of(model), noise, np.zeros(at.residual.size, bool))
    return 2.0 * float(np.log(whole.factor[:, 0]).sum())


def test_products_of_slopes_and_residual_have_no_mean(clean: tuple[Equations, SampleNoise]) -> None:
    """Along the record the mean is ``(1/2) d log|C|/db``, in closed form; along the expected motion little is left."""
    at, noise = clean
    number = next(n for n in file_numbers(at.model) if n.parameter == "stiffness" and n.of == "shoulder")
    rng, open_ = np.random.default_rng(2), np.zeros(at.residual.size, bool)
    true = of_numbers(at, (number,))  # its product with the residual has no mean, and most of the scatter
    recorded: list[float] = []
    expected: list[float] = []
    for _ in range(DRAWS):
        drawn = dataclasses.replace(at, data=tuple(_noisy(each, noise, rng) for each in at.data))
        white = whitener(drawn, noise, open_)
        along = dataclasses.replace(at, data=expected_data(drawn, noise, white, np.ones(len(at.kinds))))
        for found, motion in ((recorded, drawn), (expected, along)):
            found.append(float(white(of_numbers(motion, (number,)) - true)[:, 0] @ white(drawn.residual)))
    step = 0.01
    slope = (_log_determinant(at, noise, number, 1.0 + step) - _log_determinant(at, noise, number, 1.0 - step)) / step
    bias = 0.25 * slope
    assert abs(bias) > 10.0 * _error(recorded)
    assert np.mean(recorded) == pytest.approx(bias, abs=4.0 * _error(recorded) + 0.02 * abs(bias))
    assert abs(np.mean(expected)) < 0.15 * abs(bias)


@pytest.fixture(scope="module")
def stiff() -> fd.Recording:
    """Both encoders of a stiff arm, without noise: deflections of 0.2 and 0.4 mrad."""
    t = np.arange(2500) / 500
    sway = 1.0 - np.cos(np.outer(t, [3.0, 9.0, 4.0]))
    turns = np.stack([0.3 * sway[:, 0] + 0.1 * sway[:, 1], 1.5 + 0.4 * sway[:, 2]], axis=1)
    run = fd.simulate(_stiff(1.0), fd.PD(fd.Samples(t, turns, "cubic"), kp=3000, kd=150), q0=turns[0])
    return run.to_recording()


def _stiff(factor: float) -> fd.FlexibleJointModel:
    """Two stiff joints, whose stiffnesses in the file are wrong by a factor."""
    joints = {name: {"stiffness": factor * K, "damping": 2.0} for name, K in (("shoulder", 27000.0), ("elbow", 4400.0))}
    joints = {name: {**numbers, "rotor_inertia": 4e-5} for name, numbers in joints.items()}
    return fd.load_model("scara_two_link").replace(joints=joints, effects=[], tolerance=0.1)


@pytest.mark.parametrize(
    "bent", [[], [fd.effects.HardeningSpring("shoulder", cubic=3e11)]], ids=["linear", "hardening"]
)
def test_what_noise_does_to_rows_is_in_their_units(stiff: fd.Recording, bent: list[fd.effects.Effect]) -> None:
    """The same by equation, for a hypothesis with a softer spring and a weaker motor than the file says.

    A spring that hardens is steeper where it is wound.
    """
    model = _stiff(1.0)
    bare, _ = prepared(model, (measured(model, stiff),))
    softer = {n: 0.7 for n in file_numbers(model) if n.parameter == "stiffness"}
    weaker = fd.effects.TorqueConstantError("shoulder", gain=-0.4)
    errors = [n.error(x) for n, x in softer.items()]
    at = bare.equations.of(model.replace(effects=[weaker, *bent, *errors]))
    rng, (data,), (along,) = np.random.default_rng(1), at.data, at.motions
    samples = along.lost + at.filters.instants(len(along.t))
    for signal, size in (("q", 1e-6), ("theta", 1e-6), ("tau", 0.1)):
        n = size * rng.normal(size=data.q.shape)
        moved = dataclasses.replace(data, **{signal: getattr(data, signal) + n})
        change = dataclasses.replace(at, data=(moved,)).residual - at.residual
        y = change.reshape(-1, len(at.kinds))
        back = np.zeros(len(at.kinds))  # by equation
        for (kind, j), orders in coefficients(at, along).items():
            for row in range(len(at.kinds)) if kind == signal else ():
                own = {order: {row: terms[row]} for order, terms in orders.items() if row in terms}
                back[row] += float(onto_samples(at, (kind, j), own, y, samples, len(data.t)) @ n[:, j])
        assert back == pytest.approx((y**2).sum(axis=0), rel=0.01, abs=0.0)


def test_noise_of_both_encoders_biases_no_stiffness(stiff: fd.Recording) -> None:
    """Without the expected motion, the mean error is 6.6 standard deviations."""
    given, rng = _stiff(1.05), np.random.default_rng(3)
    levels = {"q": 3e-5, "theta": 3e-5, "tau": 0.05}
    names = [f"{signal}.{joint}" for signal in levels for joint in given.joint_names]
    off, shares = [], []
    for _ in range(DRAWS // 10):
        seen = {x: stiff[x] + rng.normal(0.0, levels[x.split(".")[0]], stiff.t.size) for x in names}
        bare, here = prepared(given, (measured(given, fd.Recording(stiff.t, seen)),))
        for _ in range(3):
            at = bare.equations.of(here.model())
            work, in_slopes = along_expected(weighed(bare, at), here, at)
            made = fit(here, for_fit(work.bare, here))
            here = made.hypothesis
        number = next(n for n in here.factors if n.of == "shoulder" and n.parameter == "stiffness")
        off.append((here.factors[number] - 1.0 / 1.05) / made.factor_std()[number])
        shares.append(in_slopes)
    assert abs(np.mean(off)) < 1.5
    assert np.std(off) < 2.0
    assert np.mean(shares) < 0.1  # slopes lack the noise of rows that have nothing else


def _error(found: list[float]) -> float:
    """Standard error of a mean."""
    values: Array = np.array(found)
    return float(values.std() / np.sqrt(len(values)))


@pytest.mark.parametrize(
    "beside", [fd.effects.Payload(mass=2.0), fd.effects.TorqueConstantError("shoulder", gain=-0.3)]
)
def test_slopes_of_numbers_follow_what_changes_the_rows(stiff: fd.Recording, beside: fd.effects.Effect) -> None:
    """A payload winds the springs, and rows are in units of the applied torque: against differences of the rows."""
    model = _stiff(1.0)
    bare, here = prepared(model, (measured(model, stiff),))
    there = dataclasses.replace(here, effects=(beside,))
    noise = SampleNoise(np.full(2, 1e-6), np.full(2, 1e-6), np.full(2, 1e-6), np.zeros(2))
    work = weighed(dataclasses.replace(bare, noise=noise, mask=np.zeros(bare.equations.residual.size, bool)))
    X = linearised(there, work).regression.X
    for k, number in enumerate(there.factors):
        sides = [
            bare.equations.of(dataclasses.replace(there, factors={**there.factors, number: 1.0 + h}).model()).residual
            for h in (1e-4, -1e-4)
        ]
        slope = work.whiten(sides[0] - sides[1]) / 2e-4
        if number.parameter != "damping":  # of 1e-4 of the others
            assert X[:, k] @ slope / (slope @ slope) == pytest.approx(1.0, abs=0.05), number
