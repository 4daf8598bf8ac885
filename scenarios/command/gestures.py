"""``vipr gestures``: train, apply and judge gesture models on tables of trajectories."""

import json
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

DataOption = Annotated[Path, typer.Option(help="Folder with sequences.csv and points.csv.gz.")]
MinOption = Annotated[int, typer.Option(min=0, help="Leave out classes with fewer sequences.")]
MaxOption = Annotated[int, typer.Option(min=0, help="Take at most so many sequences of each writer and class; 0: all.")]
ClassesOption = Annotated[str, typer.Option(help="Only these classes, separated by commas.")]
SeedOption = Annotated[int, typer.Option(min=0, help="Seed of splits and of training.")]
ModelsOption = Annotated[
    str, typer.Option(help="default, or position, velocity, combined: the 4-state models of the paper's Table II.")
]
StatesOption = Annotated[str, typer.Option(help="States of every model: a number, or validated (chosen per gesture).")]


def register(app: typer.Typer) -> None:
    """Add the subcommands to the app."""
    group = typer.Typer(help="Gesture models: train, recognise, evaluate.", no_args_is_help=True)
    app.add_typer(group, name="gestures")
    group.command("train")(train)
    group.command("recognise")(recognise)
    group.command("evaluate")(evaluate)


def train(
    data: DataOption,
    model: Annotated[Path, typer.Option(help="Model file to write (.npz).")],
    min_per_class: MinOption = 0,
    max_per_writer_class: MaxOption = 0,
    classes: ClassesOption = "",
    garbage: Annotated[str, typer.Option(help="Label of the sequences that are no gesture, to be rejected.")] = "",
    models: ModelsOption = "default",
    states: StatesOption = "",
    seed: SeedOption = 0,
) -> None:
    """Train a model of the gestures in a table and write it to a file."""
    from vipr.scenarios.experiments.evaluation import select
    from vipr.systems.errors import InputError
    from vipr.systems.gestures.model_file import save_model
    from vipr.systems.gestures.tables import read_table

    make = _maker(models, states, seed, garbage or None)
    if not model.parent.is_dir() or model.is_dir():
        raise InputError(f"--model {model}: its folder must exist and it must be a file")
    table = select(read_table(data), min_per_class, max_per_writer_class, _list(classes))
    with _progress("training") as tick:
        classifier = make().fit(table.trajectories, table.labels, tick=tick)
    save_model(classifier, model, {"sequences": len(table), "data": data.resolve().name})
    skipped = f", {len(classifier.skipped_)} unusable left out" if len(classifier.skipped_) else ""
    typer.echo(f"{model}: {len(classifier.classes_)} gestures from {len(table)} sequences{skipped}")


def recognise(
    model: Annotated[Path, typer.Option(help="Model file.")],
    data: DataOption,
    out: Annotated[Path, typer.Option(help="CSV to write: seq,label,probability,rejected.")],
) -> None:
    """Name every sequence of a table."""
    import csv

    from vipr.systems.errors import InputError
    from vipr.systems.gestures.model_file import load_model
    from vipr.systems.gestures.tables import read_table

    classifier, table = load_model(model), read_table(data)
    if not out.parent.is_dir() or out.is_dir():
        raise InputError(f"--out {out}: its folder must exist and it must be a file")
    rows = []
    with _progress("recognising") as tick:
        for a in range(0, len(table), 256):
            part = table.trajectories[a : a + 256]
            rows += zip(table.seq[a : a + 256], *classifier.recognise(part), strict=True)
            tick((a + len(part)) / len(table))
    whole = out.with_name(f".{out.name}.part")
    with whole.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["seq", "label", "probability", "rejected"])
        writer.writerows([s, label, f"{p:.4f}", int(r)] for s, label, p, r in rows)
    whole.replace(out)
    typer.echo(f"{out}: {len(rows)} sequences, {sum(bool(r[3]) for r in rows)} rejected")


def evaluate(
    data: DataOption,
    test: Annotated[Path | None, typer.Option(help="Test on this table, train on all of --data.")] = None,
    split: Annotated[
        str, typer.Option(help="writer:K, writer:all or random:K: what is held out in turn.")
    ] = "writer:5",
    min_per_class: MinOption = 0,
    max_per_writer_class: MaxOption = 0,
    classes: ClassesOption = "",
    models: ModelsOption = "default",
    states: StatesOption = "",
    seed: SeedOption = 0,
    picture: Annotated[Path | None, typer.Option(help="PNG of the confusion matrix to write.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Recognition rate on sequences of writers (or at random) held out of training."""
    from vipr.scenarios.experiments.evaluation import cross_validate, select, train_and_test
    from vipr.scenarios.experiments.evaluation import split as fold_of
    from vipr.systems.gestures.tables import read_table

    make = _maker(models, states, seed, None)
    table = select(read_table(data), min_per_class, max_per_writer_class, _list(classes))
    if test is not None:
        # Classes that were left out of training are left out of the test; unknown ones stay, and count as wrong.
        other = select(read_table(test), 0, max_per_writer_class, _list(classes))
        with _progress("training and testing") as tick:
            result = train_and_test(make, table, other, tick)
    else:
        fold = fold_of(table, split, seed)
        with _progress(f"{int(fold.max()) + 1} folds") as tick:
            result = cross_validate(make, table, fold, tick)
    summary = {
        "data": str(data),
        "test": str(test) if test else None,
        "split": None if test else split,
        "models": models,
        "seed": seed,
    }
    summary |= result.summary()
    if picture is not None:
        from vipr.scenarios.experiments.pictures import confusion_picture

        confusion_picture(result.truth, result.answer, picture, f"{data.name}: {summary['accuracy_percent']:.2f} %")
    if as_json:
        typer.echo(json.dumps(summary, indent=1))
        return
    _print(summary)


def _print(summary):
    from rich.console import Console
    from rich.table import Table

    console = Console()
    table = Table("fold", "trained on", "tested on", "right %")
    for k, fold in enumerate(summary["folds"]):
        table.add_row(str(k + 1), str(fold["trained_on"]), str(fold["tested_on"]), f"{fold['accuracy_percent']:.2f}")
    console.print(table)
    worst = sorted(summary["per_class"].items(), key=lambda item: item[1]["accuracy_percent"])[:8]
    console.print("hardest: " + ", ".join(f"{c} {v['accuracy_percent']:.1f} %" for c, v in worst))
    console.print(
        f"[bold]{summary['accuracy_percent']:.2f} %[/bold] of {summary['sequences']} sequences in {summary['classes']} classes, "
        f"{summary['ms_per_sequence']:.2f} ms a sequence"
    )


def _maker(models, states, seed, garbage):
    """A function that builds the classifier asked for."""
    from vipr.scenarios.experiments.evaluation import classifier
    from vipr.systems.errors import InputError
    from vipr.systems.gestures.classifier import STREAMS

    if models not in STREAMS:
        raise InputError(f"--models is one of {', '.join(STREAMS)}, got {models!r}")
    if states not in ("", "validated") and not (states.isdigit() and 1 <= int(states) <= 30):
        raise InputError(f"--states is a number from 1 to 30 or validated, got {states!r}")
    number = int(states) if states.isdigit() else states or None
    return partial(classifier, models, number, garbage, seed)


def _list(text):
    return [c.strip() for c in text.split(",") if c.strip()] or None


@contextmanager
def _progress(what):
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=float(share))
