"""The paper reproduced: every figure, table and claim, beside ours, each with a verdict."""

from __future__ import annotations

from omnimorph.studies.reproduction.plan import Plan
from omnimorph.studies.reproduction.run import SCHEMA, reproduce

__all__ = ["SCHEMA", "Plan", "reproduce"]
