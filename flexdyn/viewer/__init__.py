"""The viewer: a motion in the browser, drawn by meshcat, which is imported only here and only when needed.

`motion` and `sources` hold the motion of an arm, `bodies` and `solids` its shapes; `scene` makes meshcat's commands,
`show` makes its content, `page` one HTML file; `server` serves it; `playback` is for users.
"""
