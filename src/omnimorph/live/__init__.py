"""A flight that is watched and disturbed while it runs (extra ``view``)."""
