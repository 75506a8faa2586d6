"""Whatever the user got wrong is one line on stderr, exit code 2, and no file."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import Runner

ARM = """flexdyn: 1
robot: {urdf: scara_two_link}
joints:
  elbow: {rotor_inertia: 1.0e-5, gear_ratio: 100.0, stiffness: 5.5}
initial: {q: {elbow: 1.5}}
effects:
  - {effect: viscous_friction, joint: elbow, side: link, coefficient: 0.01}
"""
FILES = {
    "arm.yaml": ARM,
    "tau.csv": "t,tau.elbow\n0,0.1\n0.1,0\n",
    "other.csv": "t,tau.elbw\n0,0.1\n0.1,0\n",
    "nan.csv": "t,tau.elbow\n0,0.1\n0.1,nan\n",
    "path.csv": "t,q.elbow\n0,0.1\n0.1,0.2\n",
    "pd.yaml": "pd: {reference: path.csv, kp: [1, 2, 3], kd: 1}\n",
    "pdkey.yaml": "pd: {reference: path.csv, kpp: 1, kd: 1}\n",
    "pdref.yaml": "pd: {reference: none.csv, kp: 1, kd: 1}\n",
    "broken.urdf": "<robot name='broken'><link name='a'>",
    "broken.yaml": "flexdyn: 1\nrobot: {urdf: [\n",
    "there.yaml": "mine\n",
}
SIMULATE = ("simulate", "arm.yaml", "-o", "run.csv", "--duration", "0.1")

ARGUMENTS = [
    # commands, options, arguments
    (["simulat"], ["'simulat'", "did you mean 'simulate'?"]),
    (["fly"], ["'fly'", "known: info, new"]),
    (["--verson"], ["--verson", "did you mean '--version'?"]),
    ([*SIMULATE, "--sovler", "auto"], ["simulate", "--sovler", "did you mean '--solver'?"]),
    (["simulate", "arm.yaml", "--duration", "1", "-o"], ["-o", "requires an argument"]),
    (["simulate", "-o", "run.csv"], ["missing argument 'MODEL'"]),
    (["info"], ["missing argument 'ROBOT|MODEL'"]),
    (["info", "panda", "ur5"], ["info", "unexpected", "ur5"]),
    # files to write
    (["simulate", "arm.yaml", "--duration", "1"], ["--output", "say which file"]),
    (["simulate", "arm.yaml", "--duration", "1", "-o", "run.np"], ["run.np", "'.np'", "did you mean '.npz'?"]),
    (["simulate", "arm.yaml", "--duration", "1", "-o", "no/run.csv"], ["no/run.csv", "no such folder", "'no'"]),
    (["simulate", "arm.yaml", "--command", "tau.csv", "-o", "tau.csv"], ["tau.csv", "reads this file"]),
    (["new", "panda"], ["--output", "say which file"]),
    (["new", "panda", "-o", "panda.urdf"], ["panda.urdf", "'.urdf'", ".yaml"]),
    (["new", "panda", "-o", "there.yaml"], ["there.yaml", "exists", "--force"]),
    (["new", "pnda", "-o", "new.yaml"], ["'pnda'", "did you mean 'panda'?"]),
    (["new", "broken.urdf", "-o", "new.yaml"], ["broken.urdf", "line 1"]),
    (["new", "arm.yaml", "-o", "new.yaml"], ["arm.yaml", "a model file already"]),
    (["effects", "viscous_friction", "-o", "law.jpg"], ["law.jpg", "'.jpg'", ".png, .pdf, .svg"]),
    (["effects", "-o", "law.png"], ["NAME", "say which effect"]),
    (["effects", "payload", "-o", "law.gif"], ["law.gif", ".png"]),
    (["effects", "stribek"], ["'stribek'", "did you mean 'stribeck_friction'?"]),
    (["effects", "coulomb_fricton"], ["'coulomb_fricton'", "did you mean 'coulomb_friction'?"]),
    (["paper", "-o", "tau.csv"], ["tau.csv", "--output", "it is a file"]),
    (["paper", "-o", "tau.csv/out"], ["tau.csv/out", "in a file"]),
    # models and robots
    (["info", "pnda"], ["'pnda'", "did you mean 'panda'?"]),
    (["info", "arm.urdf"], ["arm.urdf", "no such file"]),
    (["info", "tau.csv"], ["tau.csv", "it is a recording"]),
    (["info", "."], ["it is a folder"]),
    (["info", "arm.yaml", "--q", "1"], ["--q", "2 values", "shoulder, elbow"]),
    (["info", "arm.yaml", "--q", "elbo=1"], ["--q", "'elbo'", "did you mean 'elbow'?"]),
    (["simulate", "scra", "-o", "run.csv"], ["scra", "did you mean 'scara'?"]),
    (["simulate", "kinova", "-o", "run.csv"], ["kinova", "flexdyn new kinova -o kinova.yaml"]),
    (["simulate", "broken.urdf", "-o", "run.csv"], ["broken.urdf", "flexdyn new"]),
    (["simulate", "none.yaml", "-o", "run.csv"], ["none.yaml", "no such file"]),
    (["simulate", "broken.yaml", "-o", "run.csv"], ["broken.yaml", "line"]),
    # how to simulate
    (["simulate", "arm.yaml", "-o", "run.csv"], ["--duration", "duration is missing"]),
    ([*SIMULATE[:-1], "long"], ["--duration", "'long'"]),
    ([*SIMULATE[:-1], "nan"], ["--duration", "nan"]),
    ([*SIMULATE[:-1], "-1"], ["--duration", "-1"]),
    ([*SIMULATE, "--rate", "0"], ["--rate", "above 0 Hz"]),
    ([*SIMULATE, "--rate", "1e12"], ["--rate", "samples"]),
    ([*SIMULATE, "--solver", "RungeKuta4"], ["--solver", "did you mean 'RungeKutta4'?"]),
    ([*SIMULATE, "--solver", "RungeKutta4"], ["--step", "needs a step"]),
    ([*SIMULATE, "--solver", "RungeKutta4", "--step", "0"], ["--step", "above 0", "0"]),
    ([*SIMULATE, "--solver", "RungeKutta4", "--step", "1e-3", "--rtol", "1e-6"], ["--rtol", "no such setting", "step"]),
    ([*SIMULATE, "--step", "1e-3"], ["--step", "0.001", "--solver RungeKutta4"]),
    ([*SIMULATE, "--rtol", "-1"], ["--rtol", "above 0", "-1"]),
    ([*SIMULATE, "--atol", "tight"], ["--atol", "'tight'"]),
    # first state
    ([*SIMULATE, "--q0", "1"], ["--q0", "2 values", "'1'", "shoulder, elbow"]),
    ([*SIMULATE, "--q0", "elbw=1"], ["--q0", "'elbw'", "did you mean 'elbow'?"]),
    ([*SIMULATE, "--q0", "elbow=1,2"], ["--q0", "some values name a joint"]),
    ([*SIMULATE, "--q0", "elbow=1,elbow=2"], ["--q0", "'elbow'", "twice"]),
    ([*SIMULATE, "--v0", "elbow=quick"], ["--v0 elbow", "'quick'"]),
    ([*SIMULATE, "--v0", "0,inf"], ["--v0 elbow", "finite"]),
    ([*SIMULATE, "--theta0", "equilibrum"], ["--theta0", "'equilibrum'"]),
    ([*SIMULATE, "--theta0", "shoulder=0.5"], ["--theta0 shoulder", "rigid", "0.5"]),
    # commands
    ([*SIMULATE, "--command", "none.csv"], ["none.csv", "no such file"]),
    ([*SIMULATE, "--command", "other.csv"], ["other.csv", "elbw", "shoulder, elbow"]),
    ([*SIMULATE, "--command", "nan.csv"], ["nan.csv", "tau.elbow"]),
    ([*SIMULATE, "--command", "path.csv"], ["path.csv", "no tau"]),
    ([*SIMULATE, "--command", "pd.yaml"], ["pd.yaml", "pd.kp", "2 joints"]),
    ([*SIMULATE, "--command", "pdkey.yaml"], ["pdkey.yaml", "pd.kpp", "did you mean 'kp'?"]),
    ([*SIMULATE, "--command", "pdref.yaml"], ["none.csv", "no such file"]),
]

MODELS = [
    ("stiffness:", "stifness:", ["joints.elbow.stifness", "did you mean 'stiffness'?"]),
    ("stiffness: 5.5", "stiffness: -5.5", ["joints.elbow.stiffness", "-5.5", "above 0"]),
    ("stiffness: 5.5", "stiffness: soft", ["joints.elbow.stiffness", "'soft'"]),
    ("rotor_inertia: 1.0e-5", "rotor_inertia: -1.0e-5", ["joints.elbow.rotor_inertia", "-1e-05", "at least 0"]),
    ("rotor_inertia: 1.0e-5", "rotor_inertia: 0", ["joints.elbow.rotor_inertia", "above 0"]),
    ("  elbow: {rotor", "  elbw: {rotor", ["joints.elbw", "did you mean 'elbow'?"]),
    ("initial:", "inital:", ["inital", "did you mean 'initial'?"]),
    ("initial: {q: {elbow: 1.5}}", "initial: {q: {elbow: .nan}}", ["initial.q.elbow", "finite"]),
    ("initial: {q: {elbow: 1.5}}", "initial: {p: {elbow: 1.5}}", ["initial.p", "known: q, v"]),
    ("effect: viscous_friction", "effect: viscous_frction", ["effects[0]", "did you mean 'viscous_friction'?"]),
    ("joint: elbow", "joint: elbo", ["effects[0]", "'elbo'", "did you mean 'elbow'?"]),
    ("side: link", "side: lnik", ["effects[0]", "'lnik'", "link or motor"]),
    ("coefficient: 0.01", "coeficient: 0.01", ["effects[0]", "coeficient", "did you mean 'coefficient'?"]),
    ("coefficient: 0.01", "coefficient: -0.01", ["effects[0]", "coefficient", "-0.01"]),
    (", coefficient: 0.01", "", ["effects[0]", "coefficient", "N m s/rad"]),
    ("flexdyn: 1", "flexdyn: 7", ["flexdyn", "7", "format 1"]),
    ("{urdf: scara_two_link}", "{}", ["robot.urdf", "missing"]),
    ("{urdf: scara_two_link}", "{urdf: arm.urdf}", ["robot.urdf", "'arm.urdf'", "no such file"]),
    ("{urdf: scara_two_link}", "{urdf: broken.urdf}", ["broken.urdf", "line 1"]),
    ("{urdf: scara_two_link}", "{urdf: pnda}", ["'pnda'", "did you mean 'panda'?"]),
    ("{urdf: scara_two_link}", "{urdf: scara_two_link, lock: {elbo: 0}}", ["lock", "elbo", "did you mean 'elbow'?"]),
]


@pytest.fixture(autouse=True)
def inputs(tmp_path: Path) -> None:
    """Files to be wrong about."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")


@pytest.mark.parametrize(("arguments", "said"), ARGUMENTS, ids=[" ".join(entry[0]) for entry in ARGUMENTS])
def test_a_mistake_in_the_arguments_is_one_line(
    flexdyn: Runner, tmp_path: Path, arguments: list[str], said: list[str]
) -> None:
    """Exit code 2; one line that names option, value and near miss; nothing on stdout; no file made or changed."""
    outcome = flexdyn(*arguments)
    assert outcome.code == 2, outcome
    assert outcome.out == ""
    _one_line(outcome.err, said)
    assert {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()} == FILES


@pytest.mark.parametrize("command", [("info",), ("simulate", "--duration", "0.1", "-o", "run.npz")], ids=lambda c: c[0])
@pytest.mark.parametrize(("right", "wrong", "said"), MODELS, ids=[entry[1] for entry in MODELS])
def test_a_mistake_in_the_model_file_is_one_line(
    flexdyn: Runner, tmp_path: Path, command: tuple[str, ...], right: str, wrong: str, said: list[str]
) -> None:
    """Exit code 2; one line that names the file, the key and what would be right; no run is written."""
    assert right in ARM
    (tmp_path / "wrong.yaml").write_text(ARM.replace(right, wrong, 1), encoding="utf-8")
    outcome = flexdyn(command[0], "wrong.yaml", *command[1:])
    assert outcome.code == 2, outcome
    assert outcome.out == ""
    _one_line(outcome.err, [*said, "broken.urdf" if "broken" in wrong else "wrong.yaml"])
    assert not (tmp_path / "run.npz").exists()


def test_a_step_that_is_too_long_is_the_users_to_shorten(flexdyn: Runner, tmp_path: Path) -> None:
    """A fixed step beyond the stability limit of a stiff spring ends in one line with time and remedy; no run."""
    (tmp_path / "stiff.yaml").write_text(ARM.replace("stiffness: 5.5", "stiffness: 5.5e6"), encoding="utf-8")
    arguments = ("--solver", "RungeKutta4", "--step", "0.05", "--duration", "50", "--q0", "elbow=0.1", "--v0", "1,1")
    outcome = flexdyn("simulate", "stiff.yaml", "-o", "run.npz", *arguments)
    assert outcome.code == 2, outcome
    _one_line(outcome.err, ["RungeKutta4", "t = ", "smaller step"])
    assert not (tmp_path / "run.npz").exists()


def test_a_file_that_will_not_be_read_does_not_stop_the_check_of_the_output(flexdyn: Runner) -> None:
    """Output first: a long simulation is never thrown away for a folder that is not there."""
    outcome = flexdyn("simulate", "none.yaml", "-o", "no/run.csv", "--command", "none.csv")
    _one_line(outcome.err, ["no/run.csv", "no such folder"])


def _one_line(err: str, said: list[str]) -> None:
    assert err.startswith("flexdyn: ")
    assert err.count("\n") == 1
    assert err.endswith("\n")
    for words in said:
        assert words in err
