"""Entry point of `python -m aerodrake`."""

import sys

from aerodrake.cli import main

sys.exit(main())
