"""Scenarios, the `vipr` command, experiments and benchmarks."""
