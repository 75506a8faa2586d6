"""Pictures of motions, laws and frequencies; Matplotlib and Plotly (extra ``plot``) are imported when needed."""

from flexdyn.plots.frequencies import draw_frequencies
from flexdyn.plots.laws import draw_law, example_entry
from flexdyn.plots.motions import plot
from flexdyn.plots.page import SUFFIXES
from flexdyn.plots.picture import Picture

__all__ = ["SUFFIXES", "Picture", "draw_frequencies", "draw_law", "example_entry", "plot"]
