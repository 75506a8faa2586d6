"""Files in general, independent of robots: `files` writes them completely or not at all, `yaml` reads YAML.

Formats of recordings are in `flexdyn.records`, URDF files in `flexdyn.robot`, the model file in `flexdyn.model`.
"""
