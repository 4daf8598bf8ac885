"""Benchmarks: `vipr bench NAME` prints the tables that stand in the README."""
