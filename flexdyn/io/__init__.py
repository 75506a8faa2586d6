"""Files in general, before anything is known of robots: `files` writes them whole or not at all, `yaml` reads YAML.

Formats of recordings are in `flexdyn.records`, URDF files in `flexdyn.robot`, the model file in `flexdyn.model`.
"""
