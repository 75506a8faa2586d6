"""The answer of a diagnosis: where model and measurement disagree, what is missing, and how sure that is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from flexdyn.diagnose.report import measures, origin
from flexdyn.diagnose.report.suspects import Considered, Finding, Structure
from flexdyn.diagnose.report.trace import ForceLoop, ResidualTrace, Trajectory
from flexdyn.io.notebook import Public
from flexdyn.model.flexible_joint_model import FlexibleJointModel

Verdict = Literal[
    "no_discrepancy", "explained", "partly_explained", "unexplained", "untested", "not_converged", "interrupted"
]


@dataclass(frozen=True, repr=False)
class Diagnosis(Public):
    """The answer to "where do model and measurement disagree, and what is missing?".

    Attributes:
        verdict: about the test data, or that there are none (contract, section 8).
        findings: in the order of their share of the gap.
        model: the corrected model.
        calibration: numbers that moved within three sigma of their tolerance.
        gap_fit: on the data of the fit; None where it could not be simulated.
        gap_test: on the test data; None where they were not opened or could not be simulated.
        errors: of every joint on the test data, by its name.
        where: in which equations the residual of the calibrated model appears, the largest share first.
        left: what the corrected model leaves unexplained, the largest share of the torque first.
        structures: sets of effects that were compared, the most probable first.
        data: what was read, and what for.
        notes: numbers that the data do not determine, and assumptions; one sentence each.
        seconds: that it took [s].
        record: version, date, command line and files.
        fit: how well the final fit is determined; None: there was none.
        shares: of the gap on the test data, which add up; None where it was not measured.
        stopped_at: the stage in which the user stopped it; empty if it was not stopped.
        trajectories: measured and simulated motion of every joint, over the test data and the data of the fit.
        loops: recorded and simulated force of joints whose motion a test rig prescribes.
        residuals: pictures of the residuals before and after the correction, the most informative first.
        considered: every candidate that the search compared, the most probable first.
        no_model: why model.yaml is not written; empty where it is.
        stopped: estimates that stopped short of a stationary point, in words such as "damping of elbow".

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
        >>> answer.verdict
        'explained'
        >>> answer.save("report")  # report.html, report.json, model.yaml
    """

    verdict: Verdict
    findings: tuple[Finding, ...]
    model: FlexibleJointModel
    calibration: tuple[measures.Calibration, ...] = ()
    gap_fit: measures.Gap | None = None
    gap_test: measures.Gap | None = None
    errors: Mapping[str, measures.JointError] = field(default_factory=dict)
    where: tuple[measures.ResidualPlace, ...] = ()
    left: tuple[measures.Left, ...] = ()
    structures: tuple[Structure, ...] = ()
    data: tuple[origin.RecordingSpan, ...] = ()
    notes: tuple[str, ...] = ()
    seconds: float = 0.0
    residuals: tuple[ResidualTrace, ...] = ()
    considered: tuple[Considered, ...] = ()
    no_model: str = ""
    stopped: tuple[str, ...] = ()
    trajectories: tuple[Trajectory, ...] = ()
    stopped_at: str = ""
    record: origin.Record = field(default_factory=origin.record, compare=False)
    fit: measures.Statistics | None = None
    shares: measures.Shares | None = None
    loops: tuple[ForceLoop, ...] = ()

    def __repr__(self) -> str:
        """The verdict and the names, in a line."""
        from flexdyn.diagnose.report.notebook import diagnosis_line

        return diagnosis_line(self)

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        from flexdyn.diagnose.report.notebook import diagnosis_html

        return diagnosis_html(self)

    def save(self, folder: str | Path) -> None:
        """Write report.html, report.json and model.yaml; all of them, or nothing.

        model.yaml is the corrected model, ready to be simulated: calibration, parameter errors and elasticities are
        folded into its numbers. Where numbers of links changed, a corrected URDF lies beside it. It is not written if
        `no_model` gives a reason, and one of an earlier report is then removed.

        Args:
            folder: is created if it does not exist; files of an earlier report in it are replaced.

        Raises:
            InputError: the folder cannot be made or written to.
            MissingExtra: plotly is not installed.
        """
        from flexdyn.diagnose.report.write import write_report

        write_report(self, Path(folder))

    def to_dict(self) -> dict[str, Any]:
        """As report.json holds it (contract, section 8)."""
        from flexdyn.diagnose.report.document import document

        return document(self)

    def explain(self, target: str) -> str:
        """Why an effect was named or was not, from the structures that were compared.

        Args:
            target: ``EFFECT@JOINT``, such as ``coulomb_friction@elbow``; with a side ``coulomb_friction@elbow.motor``;
                ``channel_lag@q.elbow``, ``parameter_error@elbow.stiffness``, ``payload``. An effect alone stands for
                it at every place.

        Raises:
            InputError: no such effect, or no such place; it names the near miss.
        """
        from flexdyn.diagnose.report.explain import explanation

        return explanation(self, target)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C in the middle of a diagnosis.

    Attributes:
        diagnosis: what was known by then; None where that was nothing.
    """

    def __init__(self, diagnosis: Diagnosis | None = None) -> None:
        super().__init__("the diagnosis was interrupted")
        self.diagnosis = diagnosis
