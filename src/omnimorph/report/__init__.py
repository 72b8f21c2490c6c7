"""Readers of runs and analyses: figures to be printed, tables, and pages that need no other file.

A report takes a `Run`, a `VehicleAnalysis`, or numbers; it never flies anything.

- `figures`: from flights to matplotlib figures;
- `analysis_figures`, `attitude_figures`: from an analysis to matplotlib figures;
- `vehicle_drawing`, `polytope_drawing`: vehicles, and sets of forces, seen by one camera;
- `style`: how they look, and how they are kept as SVG and PDF;
- `curves`, `thinning`, `attitudes`: what they draw: thinned to what the eye can see, on discs;
- `analysis_text`, `analysis_summary`, `analysis_data`: an analysis in sentences, and as data;
- `tables`, `page`: tables, and the HTML page around everything;
- `analysis_page`: the page of `omnimorph analyze`.
"""

from __future__ import annotations
