"""The core lets Python live: threads run beside it, and Ctrl-C stops it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import flexdyn as fd
from tests.arms import BENT, state, two_link
from tests.lock import counted_beside
from tests.oracles.two_link import TwoLink

ARM = TwoLink(stiffness=(30.0, 20.0))


def test_python_runs_beside_a_simulation() -> None:
    """A thread counts on while one call integrates: the interpreter's lock is free."""
    # A call that held the lock would leave some thousand at most.
    assert (
        counted_beside(
            lambda: fd.simulate(two_link(ARM), None, 50.0, fd.solvers.RungeKutta4(step=1e-4), rate=1, **BENT)
        )
        > 50_000
    )


def test_two_simulations_at_a_time() -> None:
    """Each thread gets its own result, the one that it gets alone, although they share the model."""
    model = two_link(ARM, [fd.effects.Payload(mass=0.2)])
    torques = [[0.1 * k, -0.2 * k] for k in range(4)]
    alone = [fd.simulate(model, tau, 2.0, **BENT) for tau in torques]
    together: dict[int, fd.Run] = {}

    def work(k: int) -> None:
        together[k] = fd.simulate(model, torques[k], 2.0, **BENT)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k, run in enumerate(alone):
        np.testing.assert_array_equal(state(together[k]), state(run))


def test_controllers_in_two_threads() -> None:
    """Python laws take turns and never see the other run's state."""
    model = two_link(ARM)

    def simulated(gain: float) -> fd.Run:
        return fd.simulate(model, fd.Controller(lambda t, x: -gain * x.omega), 0.5, **BENT)

    alone = [simulated(gain) for gain in (0.5, 2.0)]
    together: dict[int, fd.Run] = {}
    threads = [
        threading.Thread(target=lambda k=k, gain=gain: together.update({k: simulated(gain)}))
        for k, gain in enumerate((0.5, 2.0))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in (0, 1):
        np.testing.assert_array_equal(together[k].tau, alone[k].tau)


ENDLESS: dict[str, fd.solvers.Solver | str] = {
    "RungeKutta4": fd.solvers.RungeKutta4(step=1e-4),
    "DormandPrince": fd.solvers.DormandPrince(max_step=1e-4, max_steps=1e15),
    "Rosenbrock": fd.solvers.Rosenbrock(max_step=1e-4, max_steps=1e15),
    "TimeStepping": fd.solvers.TimeStepping(step=1e-4),
    "auto": "auto",
}
"""Every solver, with steps so short that 1e9 s take days."""


@pytest.mark.parametrize(("name", "python_law"), [*((name, False) for name in ENDLESS), ("RungeKutta4", True)])
def test_ctrl_c_stops_a_simulation(name: str, python_law: bool) -> None:
    """KeyboardInterrupt arrives within a run that would last for days, and leaves flexdyn usable."""
    assert {*ENDLESS} == {*fd.solvers.SOLVERS, "auto"}
    command = fd.Controller(lambda t, x: [0.0, 0.0]) if python_law else None
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        fd.simulate(two_link(ARM), command, 1e9, ENDLESS[name], rate=1e-6, **BENT)
    timer.join()
    assert fd.simulate(two_link(ARM), None, 0.1).t[-1] == pytest.approx(0.1)


def test_nothing_is_left_at_exit() -> None:
    """Models, controllers and failed runs alive at the interpreter's end give no complaint of leaks."""
    code = (
        "import flexdyn as fd\n"
        "model = fd.load_model('scara_two_link')\n"
        "control = fd.Controller(lambda t, x: [0.0, 0.0])\n"
        "run = fd.simulate(model, control, 0.1)\n"
        "try: fd.simulate(model, fd.Controller(lambda t, x: 1 / 0), 0.1)\n"
        "except ZeroDivisionError as error: kept = error\n"
        "links = fd.LinkSide(model)\n"
        "print(len(run.t))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("101\n", "")
