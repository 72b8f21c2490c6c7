"""What to command: pose tracking (`tracking`), allocation (`allocators`) and both (`controller`)."""
