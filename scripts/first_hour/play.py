"""The first hour: a URDF, three logs, a diagnosis, its report."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

from first_hour.arm import GEAR_RATIO, JOINTS, ROTOR_INERTIA, TORQUE_CONSTANT, URDF, measured, truth
from first_hour.logs import german_csv, matlab_struct, two_topics
from first_hour.user import Map, StuckError, User

FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def prepare(folder: Path) -> None:
    """What lies in the user's folder before the hour begins."""
    (folder / "arm.urdf").write_text(URDF, encoding="utf-8")
    arm = truth(folder)
    german_csv(folder / "montag.csv", *measured(arm, 0))
    two_topics(folder / "dienstag", *measured(arm, 1))
    matlab_struct(folder / "mittwoch.mat", *measured(arm, 2))


def play(user: User) -> str:
    """From the URDF to the open report.

    Returns:
        The first sentence of the report, as the browser shows it.

    Raises:
        StuckError: a step for which no message told the user how to go on.
    """
    user.want("see what is in my URDF")
    user.succeed("info", "arm.urdf")
    user.want("a model file with my gears and rotors")
    user.succeed("new", "arm.urdf", "-o", "arm.yaml")
    _fill_in(user.folder / "arm.yaml")
    user.succeed("info", "arm.yaml")
    logs = {"montag.csv": _german, "dienstag": _ros, "mittwoch.mat": _matlab}
    maps = [user.read_log(log, correct) for log, correct in logs.items()]
    user.want("know what my model lacks")
    given = [word for name in maps for word in ("--map", name)]
    fit, check = list(logs)[:2], list(logs)[2]
    user.succeed("diagnose", "arm.yaml", *fit, "--check", check, *given, "-o", "report")
    step, began = user.want("read the report in the browser"), time.monotonic()
    said = opened(user.folder / "report" / "report.html")
    step.seconds = time.monotonic() - began
    return said


def opened(report: Path) -> str:
    """The report in Chromium: its first sentence; a picture of it is saved beside it.

    Raises:
        StuckError: no browser, or an error in the page.
    """
    from playwright.sync_api import sync_playwright

    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        raise StuckError("no chromium here; Debian, Ubuntu: apt install chromium")
    errors: list[str] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(report.resolve().as_uri())
        page.screenshot(path=str(report.with_suffix(".png")))
        said = str(page.inner_text("h1"))
        browser.close()
    if errors:
        raise StuckError(f"the report has errors: {errors[0]}")
    return said


def _fill_in(file: Path) -> None:
    """The data sheet's numbers in place of the defaults."""
    text = file.read_text(encoding="utf-8")
    for key, default, number in (("gear_ratio", "1.0", GEAR_RATIO), ("rotor_inertia", "0.0", ROTOR_INERTIA)):
        if f"{key}: {default}" not in text:
            raise StuckError(f"the model file has no place for {key}")
        text = text.replace(f"{key}: {default}", f"{key}: {number}")
    file.write_text(text, encoding="utf-8")


def _named(suggested: Map) -> Map:
    """The joints by their names, in the order of the columns."""
    channels = suggested["channels"].items()
    numbered = {f"JOINT{k + 1}": joint for k, joint in enumerate(JOINTS)}
    named = {f"{name.split('.')[0]}.{numbered[name.split('.')[1]]}": column for name, column in channels}
    return suggested | {"channels": named}


def _german(suggested: Map) -> Map:
    """Names alone: the units stand in the header, and the gaps were seen."""
    return _named(suggested)


def _matlab(suggested: Map) -> Map:
    """MATLAB files state no units: positions are in degrees."""
    made = _named(suggested)
    channels = made["channels"].items()
    return made | {"channels": {x: {"from": y, "unit": "deg"} if x.startswith("q.") else y for x, y in channels}}


def _ros(suggested: Map) -> Map:
    """A line for each joint; currents of the motors become torques of the joints."""
    channels = {}
    for joint in JOINTS:
        position, effort = (suggested["channels"][f"{x}.JOINT"].replace("JOINT", joint) for x in ("q", "tau"))
        channels[f"q.{joint}"] = position
        channels[f"tau.{joint}"] = {"from": effort, "unit": "A", "side": "motor"}
    drive = {"gear_ratio": GEAR_RATIO, "torque_constant": TORQUE_CONSTANT}
    return suggested | {"joints": dict.fromkeys(JOINTS, drive), "channels": channels}
