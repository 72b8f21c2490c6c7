"""Fly: scenarios (`scenario`), plant (`plant`, `effects`), loop (`fly`); and a `thrust_stand`."""
