"""What the machine gives and asks: its memory, other processes, signals to end."""

from __future__ import annotations
