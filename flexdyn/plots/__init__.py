"""Pictures: laws of effects, frequencies over a path. Matplotlib is the extra ``plot``, imported when one is drawn."""

from flexdyn.plots.examples import example_entry
from flexdyn.plots.frequencies import draw_frequencies
from flexdyn.plots.laws import draw_law
from flexdyn.plots.page import SUFFIXES

__all__ = ["SUFFIXES", "draw_frequencies", "draw_law", "example_entry"]
