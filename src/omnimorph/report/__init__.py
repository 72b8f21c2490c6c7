"""Readers of runs: figures to be printed, tables, and a page that needs no other file.

A report takes a `Run`, or numbers; it never flies anything.

- `figures`, `summary_figures`, `vehicle_drawing`: from flights to matplotlib figures;
- `style`: how they look, and how they are kept as SVG and PDF;
- `curves`, `thinning`: what they draw, thinned to what the eye can see;
- `tables`, `page`: tables, and the HTML page around everything.
"""

from __future__ import annotations
