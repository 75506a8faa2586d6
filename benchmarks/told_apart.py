"""Whether the experiments that reports propose tell apart what they should: made by the true arm, and diagnosed.

    python benchmarks/told_apart.py CASES REPORTS [-o RESULT.json]

For every report whose "A or B" holds the truth, the case is diagnosed again for its plan, the true arm of the
benchmark's own simulator makes that motion as often as the plan says, under the case's own controller and with its
encoders and noise, and the diagnosis is asked once more with this recording beside the first one. One line a case: how
far apart the plan says that the names are, how long it takes, and what the answer was worth before and after.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent / "discovery"))
from arm_draw import JOINTS
from cases import make_case
from layout import Array
from plants import Case
from recording import record
from score import outcome
from two_link_run import PERIOD, controlled

import flexdyn as fd
from flexdyn.diagnose import Experiment, Finding


def main() -> int:
    """Make the experiments of a folder of reports, and print what they were worth."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("cases", type=Path)
    parser.add_argument("reports", type=Path)
    parser.add_argument("-o", "--output", type=Path)
    o = parser.parse_args()
    secret, rows = o.cases.parent / f"{o.cases.name}.truth", []
    for file in sorted(o.reports.glob("*/report.json")):
        truth = json.loads((secret / f"{file.parent.name}.json").read_text("utf-8"))
        if truth["family"] in ("six", "outside") or outcome(truth, json.loads(file.read_text("utf-8"))) != "half":
            continue
        rows.append(asked_again(o.cases / file.parent.name, truth))
        print(json.dumps(rows[-1]), flush=True)
    if o.output:
        o.output.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0


def asked_again(folder: Path, truth: dict[str, Any]) -> dict[str, Any]:
    """What the experiment of one case was worth."""
    model = fd.load_model(folder / "model.yaml")
    fit, check = (fd.read_recording(folder / f"{part}.npz") for part in ("fit", "check"))
    before = fd.diagnose(model, [fit], [check])
    row: dict[str, Any] = {"case": truth["case"], "names": [_names(f) for f in before.findings if f.rivals]}
    plans = [finding.plan for finding in before.findings if finding.plan is not None]
    row["before"] = outcome(truth, before.to_dict())
    if row["before"] != "half":
        return row | {"after": "no longer an A or B"}
    if not plans:
        return row | {"after": "no motion tells", "said": [f.experiment for f in before.findings if f.rivals]}
    plan = plans[0]
    row |= {"motion": plan.motion, "seconds": plan.seconds, "delta_bic": plan.delta_bic}
    if plan.payload:  # one model file holds one load
        return row | {"after": "with a payload: not made"}
    case = make_case(truth["family"], truth["seed"], truth["number"], truth["fit"], truth["check"])
    channels: dict[str, Any] = dict(made(case, plan))
    np.savez(folder / "experiment.npz", **channels)
    began = time.perf_counter()
    after = fd.diagnose(model, [fit, fd.read_recording(folder / "experiment.npz")], [check])
    row["time"] = time.perf_counter() - began
    answer = {"answer": [f.suspect.effect for f in after.findings]}
    return row | answer | {"after": outcome(truth, after.to_dict())}


def made(case: Case, plan: Experiment) -> dict[str, Array]:
    """What is recorded when the true arm makes the motion of a plan so many times."""
    reference, torques = plan.command.reference, plan.command.feedforward
    t = np.arange(round(reference.duration / PERIOD)) * PERIOD
    wanted, pushed = (
        np.stack([np.interp(t, each.t, each.values[:, j]) for j in range(len(JOINTS))], axis=1)
        for each in (reference, torques)
    )
    wanted, pushed = (np.tile(each, (plan.passes, 1)) for each in (wanted, pushed))
    run = controlled(case.plant, dataclasses.replace(case.controls[0], reference=wanted, feedforward=pushed))
    rng = np.random.default_rng([*map(ord, case.name)])
    return record(run, JOINTS, case.arm.gear_ratio, case.hidden, case.sensors, rng)


def _names(finding: Finding) -> str:
    return " OR ".join(each.effect for each in (finding.suspect, *finding.rivals))


if __name__ == "__main__":
    sys.exit(main())
