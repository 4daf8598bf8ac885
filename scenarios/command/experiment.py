"""``vipr experiment``: the paper's gesture experiments, made again from writers and people that are drawn by chance."""

import json
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

OutOption = Annotated[Path, typer.Option(help="Folder for summary.json and pictures.")]
CacheOption = Annotated[
    Path | None, typer.Option(help="Folder where films are kept once made; ~/.cache/vipr or $VIPR_CACHE.")
]
SeedOption = Annotated[int, typer.Option(min=0, help="Draws people, gestures, rooms and noise.")]
CameraOption = Annotated[
    str,
    typer.Option(help="rendered: person in a room, filmed and tracked; stand-in: projected hands with 1 px of noise."),
]
JobsOption = Annotated[int, typer.Option(min=1, help="Sittings filmed at a time; one core each.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")]
FILMING = {"rendered": "filming", "stand-in": "projecting"}


def register(app: typer.Typer) -> None:
    """Add the subcommands to the app."""
    group = typer.Typer(help="The paper's gesture experiments, again.", no_args_is_help=True)
    app.add_typer(group, name="experiment")
    group.command("graffiti")(graffiti)
    group.command("instructions")(instructions)


def graffiti(
    out: OutOption,
    camera: CameraOption = "rendered",
    alphabets: Annotated[
        int, typer.Option(min=0, help="Alphabets a writer; 0: 2230 sequences of five writers, as in the paper.")
    ] = 0,
    seed: SeedOption = 1,
    jobs: JobsOption = 1,
    cache: CacheOption = None,
    as_json: JsonOption = False,
) -> None:
    """Table II: Graffiti letters drawn in the air by five writers, half of them for training, and for writers never seen."""
    from rich.console import Console
    from rich.table import Table

    from vipr.scenarios.command.output import output_folder
    from vipr.scenarios.experiments.films import cache_folder, film
    from vipr.scenarios.experiments.graffiti import ROWS, WRITERS, by_writer, drawings, halves, sittings, table_two
    from vipr.scenarios.experiments.pictures import confusion_picture
    from vipr.systems.errors import InputError

    _check(camera)
    if alphabets == 1:
        raise InputError("--alphabets is 0 or at least 2, as half of a writer's letters are for training; got 1")
    folder, kept = output_folder(out), cache_folder(cache)
    planned = sittings(seed, camera, alphabets or None)
    with _progress(FILMING[camera], sum(len(s.labels) for s in planned)) as step:
        reels = film(planned, kept, jobs, step)
    table = drawings(reels)
    with _progress("training and testing", 1.0) as step:
        at = [0.0]

        def tick(share):
            step(share - at[0])
            at[0] = share

        results = table_two(table, seed, tick)
    tested = {"known": table.writers[~halves(table, seed)], "unseen": table.writers}
    summary = {
        "experiment": "graffiti",
        "camera": camera,
        "sequences": len(table),
        "writers": WRITERS,
        "trained_on": int(halves(table, seed).sum()),
        "seed": seed,
        "rows": {},
    }
    shown = Table("models", "paper %", "known writers %", "unseen writers %", "ms a gesture")
    paper = {"position": 96.6, "velocity": 87.7, "combined": 99.5, "default": None}
    for row, text in ROWS.items():
        known, unseen = results[row]["known"], results[row]["unseen"]
        for kind, result in results[row].items():
            title = f"{text}, {kind} writers: {result.accuracy():.2f} %"
            confusion_picture(result.truth, result.answer, folder / f"confusion_{row}_{kind}.png", title)
        ms = known.summary()["ms_per_sequence"]
        values = {
            "paper_percent": paper[row],
            "known_percent": known.accuracy(),
            "unseen_percent": unseen.accuracy(),
            "ms_per_gesture": ms,
        }
        summary["rows"][row] = {k: None if v is None else round(v, 3) for k, v in values.items()} | {
            f"{kind}_percent_by_writer": {w: round(v, 3) for w, v in by_writer(result, tested[kind]).items()}
            for kind, result in results[row].items()
        }
        shown.add_row(
            text,
            "" if paper[row] is None else f"{paper[row]}",
            f"{known.accuracy():.2f}",
            f"{unseen.accuracy():.2f}",
            f"{ms:.2f}",
        )
    (folder / "summary.json").write_text(json.dumps(summary, indent=1) + "\n")
    if as_json:
        typer.echo(json.dumps(summary, indent=1))
        return
    console = Console()
    console.print(f"{len(table)} sequences of {WRITERS} writers, {_what(camera)}")
    console.print(shown)
    for row, text in ROWS.items():
        each = by_writer(results[row]["known"], tested["known"])
        console.print(f"{text}, known: " + ", ".join(f"{w} {v:.1f} %" for w, v in each.items()))


def instructions(
    out: OutOption,
    camera: CameraOption = "rendered",
    share: Annotated[
        float, typer.Option(min=0.05, max=1.0, help="Share of the sequences; 1: 500 for training, 320 for test.")
    ] = 1.0,
    seed: SeedOption = 1,
    jobs: JobsOption = 1,
    cache: CacheOption = None,
    model: Annotated[Path | None, typer.Option(help="Write the trained model to this file.")] = None,
    as_json: JsonOption = False,
) -> None:
    """The robot's own language: trained on six people, tested on four others and on hands that mean nothing."""
    import numpy as np
    from rich.console import Console

    from vipr.scenarios.command.output import output_folder
    from vipr.scenarios.experiments import instruction_trial as trial
    from vipr.scenarios.experiments.films import cache_folder, film
    from vipr.scenarios.experiments.pictures import confusion_picture, rejection_picture
    from vipr.systems.errors import InputError
    from vipr.systems.gestures.model_file import save_model

    _check(camera)
    if model is not None and not model.resolve().parent.is_dir():
        raise InputError(f"--model {model}: its folder must exist")
    folder, kept = output_folder(out), cache_folder(cache)
    planned = [trial.sittings(test, seed, camera, share) for test in (False, True)]
    with _progress(FILMING[camera], sum(len(s.labels) for part in planned for s in part)) as step:
        training, test = (film(part, kept, jobs, step) for part in planned)
    with _progress("training", 1.0) as step:
        at = [0.0]

        def tick(done):
            step(done - at[0])
            at[0] = done

        classifier = trial.train_language(training, seed, tick=tick)
    outcome = trial.try_language(classifier, test)
    rates = trial.rates(outcome)
    gesture = outcome.truth != trial.GARBAGE
    if model is not None:
        save_model(
            classifier,
            model,
            {"language": "instructions", "camera": camera, "seed": seed, "sequences": int(classifier.counts_.sum())},
        )
    named = np.where(outcome.rejected, "rejected", outcome.answer)[gesture]
    title = f"unseen people: {rates['recognised_percent']:.1f} % recognised"
    confusion_picture(outcome.truth[gesture], named, folder / "confusion.png", title)
    here = (rates["rejected_percent"], rates["false_acceptance_percent"])
    rejection_picture(
        *trial.curve(outcome), here, folder / "rejection.png", "gestures of unseen people against idle hands"
    )
    summary = {
        "experiment": "instructions",
        "camera": camera,
        "seed": seed,
        "gestures": len(trial.LANGUAGE),
        "trained_on": int(sum((r.labels != trial.GARBAGE).sum() for r in training)),
        "tested_on": int(gesture.sum()),
        "non_gestures": int((~gesture).sum()),
        "paper_percent": 78.0,
        **{k: round(v, 2) for k, v in rates.items()},
        "pointing_error_deg": {
            "median": round(float(np.rad2deg(np.nanmedian(outcome.angle[gesture]))), 2),
            "p90": round(float(np.rad2deg(np.nanquantile(outcome.angle[gesture], 0.9))), 2),
        },
        "named_after_end_s": {
            "median": round(float(np.nanmedian(outcome.delay)), 3),
            "p95": round(float(np.nanquantile(outcome.delay, 0.95)), 3),
        },
        "per_gesture_percent": {
            str(c): round(100.0 * float((named[outcome.truth[gesture] == c] == c).mean()), 2)
            for c in np.unique(outcome.truth[gesture])
        },
    }
    (folder / "summary.json").write_text(json.dumps(summary, indent=1) + "\n")
    if as_json:
        typer.echo(json.dumps(summary, indent=1))
        return
    console = Console()
    console.print(f"{summary['trained_on']} gestures of {trial.TRAINING[0]} people for training, {_what(camera)}")
    after = summary["named_after_end_s"]
    console.print(
        f"[bold]{rates['recognised_percent']:.1f} %[/bold] of {summary['tested_on']} gestures of {trial.TEST[0]} unseen people recognised "
        f"(paper: 78 %); {rates['rejected_percent']:.1f} % rejected; {rates['false_acceptance_percent']:.1f} % of "
        f"{summary['non_gestures']} non-gestures accepted; pointing within {summary['pointing_error_deg']['median']:.0f} deg (median); "
        f"named {1000 * after['median']:.0f} ms after its end (95 %: {1000 * after['p95']:.0f} ms)"
    )


def _check(camera):
    from vipr.systems.errors import InputError

    if camera not in ("rendered", "stand-in"):
        raise InputError(f"--camera is rendered or stand-in, got {camera!r}")


def _what(camera):
    return {
        "rendered": "rendered person filmed at 25 Hz, face and hands tracked in the images",
        "stand-in": "hands projected at 25 Hz with 1 px of noise: no images, no tracker",
    }[camera]


@contextmanager
def _progress(what, total):
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=total)
        yield lambda n: bar.advance(task, float(n))
