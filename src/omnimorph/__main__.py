"""``python -m omnimorph`` is the command line, as ``omnimorph`` is."""

from __future__ import annotations

import sys

from omnimorph.cli.main import main

sys.exit(main())
