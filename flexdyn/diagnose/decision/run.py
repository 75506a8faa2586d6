"""fd.diagnose: compare structures, name the established effects, and test them on data that were not fitted."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from typing import Any

from flexdyn.checks import check_known
from flexdyn.diagnose.data.rate import advice, at_needed_rates
from flexdyn.diagnose.data.windings import with_inductance, with_lagging_current, without_inductance
from flexdyn.diagnose.decision.background import Progress, display_of, in_background
from flexdyn.diagnose.decision.split import Recordings, checked_blocks, parts, without_blocks
from flexdyn.diagnose.decision.unknown_motors import with_motors
from flexdyn.diagnose.decision.unknown_sizes import with_sizes
from flexdyn.diagnose.decision.unknown_stiffnesses import with_stiffnesses
from flexdyn.diagnose.equations.sanity import check_recordings
from flexdyn.diagnose.hypothesis.prepared import prepared, recorded_noise
from flexdyn.diagnose.hypothesis.unknown_numbers import with_guesses
from flexdyn.diagnose.hypothesis.workspace import weighed
from flexdyn.diagnose.progress import STAGES, Course, know, tell
from flexdyn.diagnose.report.result import Diagnosis, Interrupted
from flexdyn.effects import registered
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.records.given import as_recordings
from flexdyn.records.signals.gaps import apart_at_gaps
from flexdyn.simulation.electrical import with_asked_torque


def diagnose(
    model: FlexibleJointModel,
    fit: Any,
    check: Any = (),
    *,
    hold_out: Any = (),
    expect: Sequence[str] = (),
    progress: Progress | bool | None = None,
) -> Diagnosis:
    """Find where a model and measurements disagree, name the missing effects, and add them.

    Args:
        model: the present model, with its tolerance; unknown numbers are estimated.
        fit: fit data: one or several recordings, each a `Recording`, a run, a path or a pandas.DataFrame. Pieces
            between gaps in time count as separate recordings.
        check: test data, in the same form, which only the final figures and the verdict use; default: the last fifth of
            the moving part of every recording of `fit`; none where too little would be left to fit.
        hold_out: blocks of the recordings of `fit` that are also test data, pairs of first and last time [s].
        expect: names of effects that this drive probably has, for example by its data sheet: they get the prior odds of
            common effects, against something unknown that resembles them (docs/diagnosis.md, eq. 6).
        progress: called with the stage and the estimated finished share of the work; None: a progress bar with the time
            on stderr if it is a terminal, or in a notebook; False: nothing.

    Returns:
        The verdict, the findings, the corrected model.

    Raises:
        InputError: recordings that do not fit the model or are not sufficient, or an unknown effect.
        Interrupted: Ctrl-C; it has the results so far.

    Example:
        >>> drives = {"*": {"stiffness": 900.0, "damping": 1.5, "rotor_inertia": 4e-5}}
        >>> model = fd.load_model("scara_two_link").replace(joints=drives, effects=[], tolerance=0.03)
        >>> t = np.linspace(0.0, 8.0, 801)
        >>> sway = np.stack([0.6 * np.cos(1.1 * t) + 0.2 * np.cos(5 * t), 0.5 * np.cos(1.4 * t)], axis=1)
        >>> robot = model.replace(effects=[fd.effects.CoulombFriction("elbow", side="motor", level=0.6)])
        >>> run = fd.simulate(robot, fd.PD(fd.Samples(t, sway, "cubic"), kp=400, kd=20), q0=sway[0])
        >>> noise, log = np.random.default_rng(0), run.to_recording()
        >>> sigma = {"q": 2e-6, "theta": 2e-6, "tau": 0.02}  # of the encoders [rad] and of the torque [N m]
        >>> names = [f"{signal}.{joint}" for signal in sigma for joint in model.joint_names]
        >>> seen = {x: log[x] + noise.normal(0.0, sigma[x.split(".")[0]], run.t.size) for x in names}
        >>> answer = fd.diagnose(model, [fd.Recording(run.t, seen)])
        >>> [(finding.suspect.effect, finding.suspect.joint) for finding in answer.findings]
        [('coulomb_friction', 'elbow')]
    """
    fit, check, said = _recordings(fit, check, hold_out)
    # Here, as `import flexdyn` loads no scipy; only what is loaded can be limited, so that is first.
    import scipy.linalg  # noqa: F401
    from threadpoolctl import threadpool_limits

    course = Course()
    # The number of threads changes the rounding of sums: figures, and close choices, would depend on the machine.
    expected = _in_catalogue(expect)
    with threadpool_limits(limits=1, user_api="blas"), display_of(progress) as show:
        began = time.monotonic()
        try:
            return in_background(lambda: _diagnosed(model, fit, check, expected, began, said), course, show)
        except KeyboardInterrupt:
            course.stop.set()
            raise Interrupted(_found_so_far(model, course, began)) from None


def _recordings(fit: Any, check: Any, hold_out: Any) -> tuple[Recordings, Recordings, tuple[str, ...]]:
    """The pieces to be fitted and the test data, at the rates that are needed, and what was done to them."""
    fit, check = (as_recordings(given, key) for given, key in ((fit, "fit"), (check, "check")))
    if blocks := checked_blocks(hold_out):
        fit, apart = without_blocks(fit, blocks)
        check = (*check, *apart)
    fit, said = at_needed_rates(apart_at_gaps(fit))
    check, more = at_needed_rates(apart_at_gaps(check))
    return fit, check, tuple(dict.fromkeys((*said, *more)))


def _in_catalogue(expect: Sequence[str]) -> tuple[str, ...]:
    """Names of effects, each in the catalogue or the user's own.

    Raises:
        InputError: one is not.
    """
    for name in expect:
        check_known(name, registered(), "there is no such effect", key="expect", value=name)
    return tuple(expect)


def _diagnosed(
    model: FlexibleJointModel,
    fit: Sequence[Recording],
    check: Sequence[Recording],
    expect: tuple[str, ...],
    began: float,
    said: tuple[str, ...],
) -> Diagnosis:
    from flexdyn.diagnose.decision.conclusion import concluded
    from flexdyn.diagnose.decision.reported import reported
    from flexdyn.diagnose.inference.posterior import posterior

    tell(STAGES[0], 0.0)
    given = model
    model = with_motors(model, fit)
    fit, check = (
        [with_lagging_current(model, with_asked_torque(model, each)) for each in some] for some in (fit, check)
    )
    model = without_inductance(model)
    fitted, test = parts(model, fit, check)
    data = tuple(each.data for each in fitted)
    model, rigid = with_stiffnesses(model, data)
    model = with_sizes(with_guesses(model), data)
    know(model=model)
    notes = (*said, *rigid, *check_recordings(model, data), *advice(model, data))
    know(fitted=fitted, notes=notes, noise=recorded_noise(data))
    bare, start = prepared(model, data)
    tell(STAGES[1], 0.05)
    compared = dataclasses.replace(posterior(bare, start), expected=expect)
    plain = weighed(dataclasses.replace(compared.bare, noise=compared.noise))
    compared, found = reported(compared, plain)
    know(found=found, noise=compared.noise)
    answer = concluded(plain, start, compared, found, (fitted, test))
    return _finished(answer, notes, began, given)


def _found_so_far(model: FlexibleJointModel, course: Course, began: float) -> Diagnosis | None:
    """What had been found when it was stopped; None where not even the recordings had been read."""
    from flexdyn.diagnose.decision.conclusion import interrupted

    known = dict(course.known)
    if "noise" not in known:
        return None
    model = known["model"]
    answer = interrupted(model, known)
    return dataclasses.replace(_finished(answer, known["notes"], began, model), stopped_at=course.stage)


def _finished(found: Diagnosis, notes: tuple[str, ...], began: float, given: FlexibleJointModel) -> Diagnosis:
    corrected, notes = with_inductance(found.model, given), (*notes, *found.notes)
    return dataclasses.replace(found, model=corrected, notes=notes, seconds=time.monotonic() - began)
