"""See it: flights and designs in three dimensions, in the browser (extra ``view``).

==============  ===================================================================
`flight_page`   one or two runs beside their plots
`explorer_page` a vehicle that morphs under sliders, with what it can make
`pictures`      the same as picture files, drawn by a browser without a window
`server`        the page's server: on loopback, on a port of its own
==============  ===================================================================
"""
