"""What people call each metric, and the unit they read it in: one list for screens and reports."""

from __future__ import annotations

from collections.abc import Mapping

from omnimorph.results.metric import Measure
from omnimorph.results.metrics import METRICS

__all__ = ["MEASURES", "Measure"]

MEASURES: Mapping[str, Measure] = {metric.name: metric.shown for metric in METRICS}
"""Key of ``metrics.json`` -> how it is shown, in the order in which people read them."""
