"""How fast it is: what ``omnimorph bench`` measures, on the machine it runs on.

::

    print(measure().as_text())

Variants that are compared take turns in one run, so that what else the machine does meets both.
Each number is a median with the lowest and the highest; targets stand beside, nothing asserts them.
"""

from __future__ import annotations

from omnimorph.bench.measurement import BenchReport, Measurement
from omnimorph.bench.suite import measure

__all__ = ["BenchReport", "Measurement", "measure"]
