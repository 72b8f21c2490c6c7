"""What came out of a flight: `run`, its `metrics`, and how they are kept (`store`, `folder`)."""

from __future__ import annotations
