"""The model of an arm and its file, as plain immutable data.

`flexible_joint_model` joins a robot, its joints' drives (`joint`) and effects into one model; `model_file` reads and
writes it as YAML, and finds it in a saved run. `setting_checks` refuses entries that do not fit the
robot. `resolved_parameters` applies parameter errors and joint elasticities to the parameters that
they change; `uncertain_parameters` lists the parameters that may be wrong, each with its tolerance.
"""
