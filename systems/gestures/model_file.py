"""Trained classifiers on disk: one .npz of plain arrays with a JSON header, checked when read; nothing is executed."""

import json
import os
import zipfile
import zlib
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np

from vipr.systems.errors import InputError
from vipr.systems.gestures.classifier import STREAMS, GestureClassifier
from vipr.systems.gestures.discriminative import SharpBank
from vipr.systems.gestures.hmm import HmmBank
from vipr.systems.gestures.rejection import Gate, Pace
from vipr.systems.gestures.stream_models import StreamModel
from vipr.systems.gestures.trajectories import Stream

FORMAT, VERSION = "vipr-gestures", 4
BANKS = {"likelihood": HmmBank, "sharp": SharpBank}


def save_model(classifier: GestureClassifier, path: Path, notes: dict | None = None) -> None:
    """Write a fitted classifier; ``notes`` (plain values) go into its header. The file appears whole or not at all."""
    path, arrays = Path(path), {}
    streams = []
    for n, model in enumerate(classifier.streams_):
        kind = "sharp" if isinstance(model.bank, SharpBank) else "likelihood"
        streams.append({"kind": kind, **asdict(model.stream)})
        arrays |= _arrays(f"stream{n}", model.bank) | {f"stream{n}.of": model.classes}
    gate = classifier.gate_
    arrays |= _arrays("gestures", gate.gestures) | _arrays("anything", gate.anything)
    arrays |= {"counts": classifier.counts_, "threshold": np.array(gate.threshold)}
    arrays |= {"pace": np.stack([classifier.pace_.middle, classifier.pace_.spread])}
    parameters = {k: v for k, v in classifier.get_params().items() if k != "streams"}
    named = classifier.streams if isinstance(classifier.streams, str) else None
    header = {
        "format": FORMAT, "version": VERSION, "classes": [str(c) for c in classifier.classes_], "garbage": classifier.garbage_,
        "dimension": classifier.dimension_, "streams": streams, "named": named, "parameters": parameters, "notes": notes or {},
    }  # fmt: skip
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("wb") as file:
            np.savez_compressed(file, header=np.array(json.dumps(header)), **arrays)
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise InputError(f"gesture model {path}: cannot be written ({error.strerror})") from None


def load_model(path: Path) -> GestureClassifier:
    """Read a classifier that ``save_model`` wrote; anything else is an ``InputError``. Labels come back as text."""
    try:
        if not zipfile.is_zipfile(path) and Path(path).is_file():
            raise InputError(f"gesture model {path}: is truncated or no model file")
        with np.load(path, allow_pickle=False) as file:
            if "header" not in file:
                raise InputError(f"gesture model {path}: is not a {FORMAT} file")
            header = json.loads(str(file["header"]))
            if not isinstance(header, dict) or header.get("format") != FORMAT:
                raise InputError(f"gesture model {path}: is not a {FORMAT} file")
            if header.get("version") != VERSION:
                raise InputError(
                    f"gesture model {path}: is of version {header.get('version')}, this program reads version {VERSION}"
                )
            arrays = {name: file[name] for name in file.files}
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"gesture model {path}: cannot be read ({error.strerror or 'not a model file'})") from None
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error, NotImplementedError):
        raise InputError(f"gesture model {path}: is truncated or no model file") from None
    try:
        return _build(header, arrays)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise InputError(f"gesture model {path}: is damaged ({' '.join(str(error).split())[:80]})") from None


def _build(header, arrays):
    classifier = GestureClassifier(**header["parameters"])
    classifier.classes_ = np.array(header["classes"], str)
    C = len(classifier.classes_)
    classifier.counts_, classifier.dimension_ = arrays["counts"], int(header["dimension"])
    classifier.garbage_, classifier.skipped_ = int(header["garbage"]), np.zeros(0, int)
    classifier.streams_ = []
    for n, entry in enumerate(header["streams"]):
        kind = entry.pop("kind")
        stream = Stream(**{**entry, "features": tuple(entry["features"])})
        bank, classes = _bank(BANKS[kind], f"stream{n}", arrays), arrays[f"stream{n}.of"]
        if set(classes.tolist()) != set(range(C)) or (np.diff(classes) < 0).any():
            raise ValueError("classes of the models")
        classifier.streams_.append(StreamModel(stream, bank, classes))
    named = header["named"]
    classifier.streams = named if named in STREAMS else tuple(model.stream for model in classifier.streams_)
    if tuple(model.stream for model in classifier.streams_) != classifier._streams() or classifier.counts_.shape != (
        C,
    ):
        raise ValueError("streams")
    classifier.gate_ = Gate(
        _bank(HmmBank, "gestures", arrays), _bank(HmmBank, "anything", arrays), float(arrays["threshold"])
    )
    classifier.pace_ = Pace(*arrays["pace"])
    if classifier.pace_.middle.shape != (C,) or not np.isfinite(arrays["pace"]).all():
        raise ValueError("pace")
    return classifier


def _arrays(name, bank):
    return {f"{name}.{f.name}": getattr(bank, f.name) for f in fields(bank)}


def _bank(kind, name, arrays):
    parts = {f.name: arrays[f"{name}.{f.name}"] for f in fields(kind)}
    for key, value in parts.items():
        if value.dtype.kind not in "fi" or np.isnan(value).any():
            raise ValueError(f"{name}.{key}")
    models = parts["stay"].shape
    if any(
        parts[k].shape[: len(models)] != models
        for k in ("means", "covariances", "log_weights", "weights", "leave")
        if k in parts
    ):
        raise ValueError(f"{name}: shapes disagree")
    return kind(**parts)
