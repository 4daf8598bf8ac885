"""Many runs of one scenario, some at a time."""

from collections.abc import Sequence
from pathlib import Path

from vipr.scenarios.catalogue import find_scenario
from vipr.scenarios.run import run_scenario
from vipr.scenarios.settings import load_settings
from vipr.scenarios.workers import in_processes

Variant = tuple[Sequence[str], Path]  # overrides of the settings, the folder for its runs


def run_many(scenario: str, variants: Sequence[Variant], seeds: Sequence[int], jobs: int = 1) -> list[list[dict]]:
    """Summaries of each variant's runs in the order of the seeds, ``jobs`` at a time; a run leaves ``FOLDER/seed-N`` behind.

    Wrong settings are refused before anything runs (InputError).
    """
    for overrides, _ in variants:
        _planned(scenario, overrides, seeds[0]).build()
    calls = [(scenario, list(overrides), seed, folder) for seed in seeds for overrides, folder in variants]
    summaries = list(in_processes(_run_one, calls, jobs))
    return [summaries[k :: len(variants)] for k in range(len(variants))]


def _planned(scenario: str, overrides: Sequence[str], seed: int):
    found = find_scenario(scenario)
    return found(load_settings(found.settings_type, found.settings_file(), list(overrides)), seed)


def _run_one(scenario: str, overrides: list[str], seed: int, folder: Path) -> dict:
    return run_scenario(_planned(scenario, overrides, seed), folder / f"seed-{seed}")
