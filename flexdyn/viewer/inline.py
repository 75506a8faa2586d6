"""The player's page within a notebook."""

from __future__ import annotations

from dataclasses import dataclass

from flexdyn.io.html import render


@dataclass(frozen=True, repr=False)
class Inline:
    """A page that a notebook shows in a frame of its own, which has no access to the notebook.

    Attributes:
        text: of the page.
        height: of the frame [px].
    """

    text: str
    height: int

    def _repr_html_(self) -> str:
        """The frame, with the page in it."""
        return render("viewer/inline.html", text=self.text, height=self.height)

    def __repr__(self) -> str:
        """The text that is shown without a notebook."""
        return f"<Inline: a page of {len(self.text) / 1e6:.1f} MB for a notebook; fd.play(run) opens the browser>"
