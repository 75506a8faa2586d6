"""What drives an arm, as plain immutable data that knows no model and no recording.

`commands` holds torques over time, joint tracking, controllers written in Python and external wrenches; `servo` is the
position and velocity loop of an industrial drive. `flexdyn.simulation.command_input` prepares them for the core.
"""
