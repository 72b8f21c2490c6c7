"""What to command: pose tracking (`tracking`), allocation (`allocators`), both (`controller`).

`tilt_cost` computes what an allocation costs at any tilt.
"""
