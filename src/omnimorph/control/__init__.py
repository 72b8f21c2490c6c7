"""What to command: pose tracking (`tracking`), allocation (`allocators`), both (`controller`)."""
