"""fd.diagnose: compare structures, name what is established, and test it on data that took no part."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from flexdyn.diagnose.decision.split import parts
from flexdyn.diagnose.equations.sanity import check_recordings
from flexdyn.diagnose.hypothesis.workspace import prepared, weighed
from flexdyn.diagnose.report.result import Diagnosis, Interrupted
from flexdyn.effects import registered
from flexdyn.errors import InputError, did_you_mean
from flexdyn.model.flexible_joint_model import FlexibleJointModel
from flexdyn.records import Recording
from flexdyn.records.given import as_recordings
from flexdyn.records.signals.gaps import apart_at_gaps

if TYPE_CHECKING:
    from flexdyn.diagnose.decision.corrected import Corrected

Progress = Callable[[str, float], None]


def diagnose(
    model: FlexibleJointModel,
    fit: Any,
    check: Any = (),
    *,
    expect: Sequence[str] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """Find where a model and measurements disagree, name the missing effects, and add them.

    Args:
        model: as it is believed to be, with its tolerance.
        fit: recordings to learn from: one or several, each a `Recording`, a run, a path or a pandas.DataFrame. Pieces
            between gaps in time count as recordings of their own.
        check: test data, given likewise, which only the final figures and the verdict read; none: the last fifth of
            what moves in every recording of `fit`.
        expect: names of effects that this drive is likely to have, by its data sheet or its like: they are told from
            something unknown that looks like them by the odds of common effects (docs/diagnosis.md, eq. 6).
        progress: called with the stage and the share of it that is done.

    Returns:
        The verdict, the findings, the corrected model.

    Raises:
        InputError: recordings that do not fit the model or cannot answer, an unknown effect.
        Interrupted: Ctrl-C, with what was known by then.

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
    fit, check = (apart_at_gaps(as_recordings(given, key)) for given, key in ((fit, "fit"), (check, "check")))
    # Here, as `import flexdyn` loads no scipy; only what is loaded can be limited, so that is first.
    import scipy.linalg  # noqa: F401
    from threadpoolctl import threadpool_limits

    # Threads of the linear algebra share a sum out by their number and round it otherwise: the last digit of every
    # figure, and a choice between structures that are equally likely, would depend on the machine.
    with threadpool_limits(limits=1, user_api="blas"):
        return _diagnosed(model, fit, check, _known(expect), progress or (lambda stage, share: None))


def _known(expect: Sequence[str]) -> tuple[str, ...]:
    """Names of effects, each in the catalogue or the user's own.

    Raises:
        InputError: one is not.
    """
    for name in expect:
        if name not in registered():
            remedy = did_you_mean(name, registered())
            raise InputError("there is no such effect", key="expect", value=name, remedy=remedy)
    return tuple(expect)


def _diagnosed(
    model: FlexibleJointModel,
    fit: Sequence[Recording],
    check: Sequence[Recording],
    expect: tuple[str, ...],
    say: Progress,
) -> Diagnosis:
    from flexdyn.diagnose.decision.conclusion import concluded, interrupted
    from flexdyn.diagnose.decision.corrected import corrected
    from flexdyn.diagnose.inference.passes import posterior

    began = time.monotonic()
    say("reading the equations", 0.0)
    fitted, test = parts(model, fit, check)
    data = tuple(each.data for each in fitted)
    notes = check_recordings(model, data)
    found: Corrected | None = None
    try:
        bare, noise, start = prepared(model, data)
        say("comparing structures", 0.0)
        compared = dataclasses.replace(posterior(bare, noise, start), expected=expect)
        plain = weighed(bare, compared.noise, compared.fitted.space.whiten.mask)
        found = corrected(compared, plain)
        answer = concluded(plain, start, compared, found, (fitted, test), say)
    except KeyboardInterrupt:
        known = None if found is None else interrupted(found, compared.noise, fitted)
        raise Interrupted(known and _finished(known, notes, began)) from None
    return _finished(answer, notes, began)


def _finished(found: Diagnosis, notes: tuple[str, ...], began: float) -> Diagnosis:
    return dataclasses.replace(found, notes=(*notes, *found.notes), seconds=time.monotonic() - began)
