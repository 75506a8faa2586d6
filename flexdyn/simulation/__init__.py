"""From a model and a command to a simulated motion.

`simulate` runs one simulation or many. For each, `job` brings together the compiled `plant`, the command
(`given_command` reads it, `command_input` prepares it), `wrenches` from outside, the first state (`initial_state`) and
the solver (`solvers` holds the settings, `solver_choice` decides what ``auto`` takes). The answer is a `run`, made of
what `inputs_and_signals` describes. `energy` integrates every power along the motion once more.
`parameter_variants` integrates many runs of one model whose parameters differ.
"""
