"""fd.play: a motion in the browser, or in one HTML file."""

from __future__ import annotations

import os
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from flexdyn.errors import InputError
from flexdyn.io.files import write_text
from flexdyn.viewer import sources
from flexdyn.viewer.page import Inline
from flexdyn.viewer.show import motion_page
from flexdyn.viewer.sources import Model, Source

if TYPE_CHECKING:
    from flexdyn.viewer.server import PageServer


@dataclass(frozen=True, eq=False)
class Playback:
    """A page that is being served, or was written.

    Attributes:
        url: its address.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> playback = fd.play(run, html="run.html")  # written; without html it is served
        >>> playback.close()
    """

    url: str
    _server: PageServer | None

    def close(self) -> None:
        """Stop serving; a file stays."""
        if self._server is not None:
            self._server.close()

    def wait(self) -> None:
        """Serve until Ctrl-C, then close."""
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            self.close()

    def __enter__(self) -> Playback:
        """Serve within a block."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Close at its end."""
        self.close()


def play(
    run: Source,
    compare: Source | None = None,
    *,
    model: Model | None = None,
    command: Any = None,
    html: str | Path | None = None,
    magnify: float | None = None,
    open_browser: bool = True,
    block: bool | None = None,
) -> Playback:
    """Show a motion in the browser: the arm, magnified deflections of its joints, the path of its tip, a time slider.

    The page is served on 127.0.0.1 only, or written as one HTML file that works offline; it loads nothing else.

    Args:
        run: a run, a recording, the path of one, or a model, which is shown at its initial position.
        compare: motion of a translucent second arm: another run of the arm, measured data, or ``"rigid"``: the arm
            without elasticity (`FlexibleJointModel.rigid`), simulated from the same first q and v. The controller of a
            run drives this arm too. Otherwise it replays the tau of the run, held from sample to sample; for a
            recording the page says so, because the tau may come from a controller.
        model: of a recording that does not contain its model (CSV never does), or its path or name.
        command: with ``"rigid"``: the command of that arm, as for `simulate`; for a recording, the controller with
            which it was made.
        html: write the page there instead of serving it.
        magnify: factor of theta - q on the dials; default: one of 1, 2, 5, 10, ... that fits the largest deflection.
        open_browser: open the page in the user's browser.
        block: return only after Ctrl-C; default: True if Python is not interactive, because serving would end with it.

    Returns:
        The page's `url`, and `close()`.

    Raises:
        InputError: no model, no positions of its joints, another arm to compare with, no tau for a rigid one, or a
            file that cannot be written.
        SimulationError: the rigid arm could not be simulated.

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> playback = fd.play(run, compare="rigid", html="run.html")
    """
    shown = sources.first(run, model)
    if command is not None and compare is None:
        raise InputError("there is no second arm to drive", key="command", remedy='give compare="rigid" too')
    ghost = None if compare is None else sources.second(compare, model, shown, command)
    text = motion_page(shown.model, shown.motion, ghost, magnify)
    if html is not None:
        write_text(Path(html), text)
        return Playback(Path(html).resolve().as_uri(), None)
    from flexdyn.viewer.server import PageServer

    server = PageServer(text)
    playback = Playback(server.url, server)
    if open_browser and _has_screen():
        import webbrowser

        webbrowser.open(playback.url)
    if not (hasattr(sys, "ps1") or sys.flags.interactive) if block is None else block:
        playback.wait()
    return playback


def inline(run: Source, compare: Source | None = None, *, command: Any = None, height: int = 560) -> Inline:
    """The page of a motion for a notebook.

    Args:
        run: as for `play`.
        compare: likewise.
        command: likewise.
        height: of the frame [px].

    Raises:
        InputError: as `play`.
        SimulationError: the rigid arm could not be simulated.
    """
    shown = sources.first(run, None)
    ghost = None if compare is None else sources.second(compare, None, shown, command)
    return Inline(motion_page(shown.model, shown.motion, ghost), height)


def _has_screen() -> bool:
    """Whether a browser can open a window; otherwise Python would start a text browser in the terminal."""
    if sys.platform != "linux":
        return True
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))
