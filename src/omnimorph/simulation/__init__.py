"""Fly: scenarios (`scenario`), the plant and its imperfections (`plant`, `effects`), the loop (`fly`)."""
