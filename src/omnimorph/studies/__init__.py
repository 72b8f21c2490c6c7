"""Questions that take many flights; `reproduction` flies what the paper flew."""

from __future__ import annotations
