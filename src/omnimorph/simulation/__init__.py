"""Fly: scenarios (`scenario`), the plant (`plant`, `effects`) and the loop (`fly`)."""
