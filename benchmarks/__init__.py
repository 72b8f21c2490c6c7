"""Benchmarks that come with the repository and not with the installed package."""
