"""Commands of an arm, as plain immutable data, independent of models and recordings.

`samples` holds values over time; `commands` joint tracking, controllers written in Python and external wrenches;
`servo` is the position and velocity loop of an industrial drive, `points` reads commands from YAML.
`flexdyn.simulation.command_input` prepares them for the core.
"""
