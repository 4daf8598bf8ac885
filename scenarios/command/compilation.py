"""``vipr compile``: what the first use of the tracker, of the arm's guard and of seeing people would compile, now."""

import time

import typer


def register(app: typer.Typer) -> None:
    """Add the subcommand to the app."""
    app.command("compile")(compile_)


def compile_() -> None:
    """Compile the inner loops of tracker, arm and seeing people ahead of their first use, once for this machine; `make setup` does it."""
    from vipr.systems.arm.shapes import compile_gaps
    from vipr.systems.hands.ahead_of_time import compile_people
    from vipr.systems.tracking.ahead_of_time import compile_tracker

    begin = time.perf_counter()
    compile_tracker()
    compile_gaps()
    compile_people()
    print(f"tracker, clearance and the sight of people are compiled ({time.perf_counter() - begin:.1f} s)")
