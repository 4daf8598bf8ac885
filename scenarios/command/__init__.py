"""The ``vipr`` command: one module a subcommand, errors of the user as one line and exit code 2."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: threads only fight over two cores

import sys
from typing import Annotated

import typer

from vipr.scenarios.command import (
    analyse,
    bench,
    calibrate,
    compare,
    compilation,
    experiment,
    gestures,
    grasp,
    hands,
    run,
    teach,
    track,
)
from vipr.scenarios.command.output import print_error
from vipr.systems.errors import InputError

app = typer.Typer(
    name="vipr",
    help="Vision for Interaction with People and Robots.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
run.register(app)
compare.register(app)
teach.register(app)
track.register(app)
hands.register(app)
gestures.register(app)
experiment.register(app)
grasp.register(app)
bench.register(app)
analyse.register(app)
calibrate.register(app)
compilation.register(app)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"vipr {version('vipr')}, drake {version('drake')}, Python {sys.version.split()[0]}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print versions and exit.")
    ] = False,
) -> None:
    pass


def main(arguments: list[str] | None = None) -> None:
    """Run the command. Exit codes: 0 done, 1 the run failed its task, 2 bad input, 130 interrupted."""
    try:
        code = app(arguments, standalone_mode=False)
    except InputError as error:
        print_error(str(error))
        code = 2
    except (KeyboardInterrupt, typer.Abort):
        print_error("interrupted")
        code = 130
    except Exception as error:
        if not hasattr(error, "format_message"):  # of the command-line library: a wrong option, a missing argument
            raise
        if type(error).__name__ == "NoArgsIsHelpError":
            print(error.format_message())
        else:
            print_error(error.format_message())
        code = 2
    sys.exit(code if isinstance(code, int) else 0)
