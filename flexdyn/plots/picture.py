"""A page of panels as plain data: two renderers draw the same page, for files and for the browser."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from flexdyn.errors import visible
from flexdyn.io.notebook import Public
from flexdyn.plots.page import checked_path
from flexdyn.plots.panel import Key, Panel

FILES = (".png", ".pdf", ".svg", ".html")
"""Formats of pictures of motions; .html is interactive."""
LEFT, HEADLINE, LINE = 0.88, 0.46, 0.18
"""Left margin of axes and of texts; height of the page's title, of a line of notes [inch]."""
KEY = 0.21
"""Height of a line of the shared legend [inch]."""
LETTER, BOLD = 0.073, 0.132
"""Width of a letter in notes and legends, and in the title [inch]."""


@dataclass(frozen=True, eq=False, repr=False)
class Picture(Public):
    """A page of panels; in a notebook it shows itself.

    Attributes:
        title: of the page.
        notes: sentences under it: what was left out, where the data come from.
        panels: with their places.
        keys: lines of the legend that all panels without their own legend share.
        width: of the page [inch].
        height: of the page [inch].

    Example:
        >>> run = fd.simulate(fd.load_model("scara_two_link"), duration=0.5, v0=[1.0, -2.0])
        >>> run.plot().save("run.svg")
    """

    title: str
    notes: tuple[str, ...]
    panels: tuple[Panel, ...]
    keys: tuple[Key, ...]
    width: float
    height: float

    @cached_property
    def lines(self) -> tuple[str, ...]:
        """The notes as lines that fit the page."""
        letters = int((self.width - 2.0 * LEFT) / LETTER)
        return tuple(line for note in self.notes for line in textwrap.wrap(note, letters))

    @property
    def headline(self) -> str:
        """The title, shortened to the width of the page."""
        letters = int((self.width - 1.5 * LEFT) / BOLD)
        return self.title if len(self.title) <= letters else f"{self.title[: letters - 1]}…"

    @property
    def key_width(self) -> float:
        """Of a line of the shared legend [inch]."""
        return max((len(key.label) for key in self.keys), default=0) * LETTER + 0.6

    @property
    def legend_columns(self) -> int:
        """Number of columns of the shared legend; it is filled row by row."""
        return max(1, min(len(self.keys), int((self.width - 1.2 * LEFT) / self.key_width)))

    @property
    def legend_at(self) -> float:
        """Distance from the upper edge of the page to that of the shared legend [inch]."""
        return HEADLINE + LINE * len(self.lines) + 0.08

    def note_at(self, line: int) -> float:
        """Distance from the upper edge of the page to the lower end of a line of notes [inch]."""
        return HEADLINE + LINE * (line + 0.75)

    def save(self, path: str | Path) -> None:
        """Write it: .png, .pdf and .svg by Matplotlib, .html interactive by Plotly, in one file that works offline.

        Raises:
            InputError: the suffix is not known, or the file cannot be written.
            MissingExtra: matplotlib or plotly is not installed.
        """
        file = checked_path(path, FILES)
        if file.suffix.lower() == ".html":
            from flexdyn.plots.plotly_picture import write_page as write
        else:
            from flexdyn.plots.matplotlib_picture import write_picture as write
        write(self, file)

    def show(self) -> Path:
        """Open it in the browser, as a page in a new folder for temporary files.

        Returns:
            The page's path; nothing else happens if no browser can be opened.

        Raises:
            MissingExtra: plotly is not installed.
        """
        import tempfile
        import webbrowser

        path = Path(tempfile.mkdtemp(prefix="flexdyn-")) / "plot.html"
        self.save(path)
        webbrowser.open(path.as_uri())
        return path

    def figure(self) -> Any:
        """Matplotlib's figure, which can be changed.

        Raises:
            MissingExtra: matplotlib is not installed.
        """
        from flexdyn.plots.matplotlib_picture import draw

        return draw(self)

    def plotly(self) -> Any:
        """Plotly's figure, which can be changed.

        Raises:
            MissingExtra: plotly is not installed.
        """
        from flexdyn.plots.plotly_picture import draw

        return draw(self)

    def __repr__(self) -> str:
        """Title and panels, in a line."""
        return visible(f"<Picture {self.title}: {len(self.panels)} panels; .show(), .save(path)>")

    def _repr_mimebundle_(self, *arguments: Any, **settings: Any) -> Any:
        """HTML for notebooks; like the pages, without a button that uploads the data."""
        from flexdyn.plots.plotly_picture import CONFIG

        return self.plotly()._repr_mimebundle_(*arguments, **{"config": CONFIG, **settings})
