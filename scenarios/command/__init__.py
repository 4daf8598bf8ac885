"""The ``vipr`` command: one module a subcommand, errors of the user as one line and exit code 2."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: threads only fight over two cores

import sys

import typer

from vipr.scenarios.command import bench, gestures, hands, run, track
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
track.register(app)
hands.register(app)
gestures.register(app)
bench.register(app)


def main(arguments: list[str] | None = None) -> None:
    """Run the command. Exit codes: 0 done, 1 the run failed its task, 2 bad input, 130 interrupted."""
    try:
        app(arguments)
    except InputError as error:
        print_error(str(error))
        sys.exit(2)
    except KeyboardInterrupt:
        print_error("interrupted")
        sys.exit(130)
