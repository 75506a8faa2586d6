"""The viewer: a motion in the browser, drawn by meshcat, which is imported nowhere else and only when needed.

motion, sources -> what an arm did; bodies, dials, solids -> shapes; scene, animation -> meshcat's commands; show ->
the page's content; page -> one HTML file; server -> who serves it; playback -> what users call.
"""

from flexdyn.viewer.playback import Playback, play

__all__ = ["Playback", "play"]
