"""``python -m flexdyn_program`` is ``flexdyn``."""

import sys

from flexdyn_program import main

sys.exit(main())
