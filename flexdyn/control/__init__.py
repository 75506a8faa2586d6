"""Commands of an arm, as plain immutable data, independent of models and recordings.

`commands` holds torques over time, joint tracking, controllers written in Python and external wrenches; `servo` is the
position and velocity loop of an industrial drive. `flexdyn.simulation.command_input` prepares them for the core.
"""
