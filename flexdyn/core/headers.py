"""Prints the include folders of Pinocchio and Eigen, which come from wheels, for CMake.

They need not lie in the same place: an environment that has pin already, but not Eigen, comes before the build's own.
"""

import sys
from pathlib import Path

WANTED = {"pin>=4.1": "pinocchio/algorithm/aba.hpp", "cmeel-eigen>=3.4": "eigen3/Eigen/Core"}


def folder(header: str) -> Path | None:
    """The first include folder of a cmeel wheel on Python's path that holds a header."""
    for entry in map(Path, sys.path):
        # Site-packages, or cmeel's own within it, which its .pth file puts on the path.
        above = [entry / "cmeel.prefix", *list(entry.parents)[:3]]
        for include in (prefix / "include" for prefix in above):
            if (include / header).is_file():
                return include
    return None


found = {need: folder(header) for need, header in WANTED.items()}
missing = [need for need, place in found.items() if place is None]
if missing:
    sys.exit(f"headers are missing: install the build requirement {' and '.join(missing)}")
pinocchio, eigen = found.values()
sys.stdout.write(f"{pinocchio};{eigen}/eigen3")
