"""``python -m flexdyn``: the command line if the program ``flexdyn`` is not on the path."""

import sys

from flexdyn.cli import main

sys.exit(main())
