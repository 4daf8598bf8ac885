"""What a file of a classifier keeps, and which files are refused."""

import json

import numpy as np
import pytest
from drawn_shapes import drawings, quick

from vipr.systems.errors import InputError
from vipr.systems.gestures.model_file import load_model, save_model


@pytest.mark.parametrize("discriminative", [True, False])
def test_a_file_keeps_every_answer(tmp_path, discriminative):
    X, y = drawings(np.random.default_rng(19), each=4)
    classifier = quick(discriminative=discriminative, timed=True).fit(X, y)
    save_model(classifier, tmp_path / "m.npz")
    again = load_model(tmp_path / "m.npz")
    np.testing.assert_array_equal(again.predict_proba(X), classifier.predict_proba(X))
    for ours, theirs in zip(classifier.recognise(X), again.recognise(X), strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.fixture(scope="module")
def model_bytes(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "m.npz"
    save_model(quick().fit(*drawings(np.random.default_rng(0))), path)
    return path.read_bytes()


def test_a_truncated_file_is_refused(model_bytes, tmp_path):
    for share in (0.0, 0.1, 0.5, 0.9, 0.999):
        (tmp_path / "cut.npz").write_bytes(model_bytes[: int(share * len(model_bytes))])
        with pytest.raises(InputError, match=r"gesture model .*cut\.npz"):
            load_model(tmp_path / "cut.npz")


def test_foreign_files_are_refused_by_what_they_are(model_bytes, tmp_path):
    path = tmp_path / "m.npz"
    with pytest.raises(InputError, match="cannot be read"):
        load_model(tmp_path / "missing.npz")
    path.write_text("hello")
    with pytest.raises(InputError, match="no model file"):
        load_model(path)
    np.savez(path, a=np.zeros(3))
    with pytest.raises(InputError, match="is not a vipr-gestures file"):
        load_model(path)
    np.save(tmp_path / "one.npy", np.zeros(3))
    with pytest.raises(InputError, match=r"no model file"):
        load_model(tmp_path / "one.npy")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda h, a: h.update(version=99), "is of version 99, this program reads version 4"),
        (lambda h, a: h.update(classes=h["classes"][:-1]), "is damaged"),
        (lambda h, a: a.pop("stream0.weights"), "is damaged"),
        (lambda h, a: a.update({"stream0.stay": a["stream0.stay"][:-1]}), "is damaged"),
        (lambda h, a: a.update({"gestures.means": a["gestures.means"] * np.nan}), "is damaged"),
        (lambda h, a: a.update(pace=a["pace"][:, :-1]), "is damaged"),
        (lambda h, a: h["parameters"].update(colour="red"), "is damaged"),
        (lambda h, a: h["streams"][0].update(points=1), "is damaged|at least 4 points"),
    ],
)
def test_a_changed_file_is_refused(model_bytes, tmp_path, change, message):
    path = tmp_path / "m.npz"
    path.write_bytes(model_bytes)
    with np.load(path) as file:
        arrays = dict(file)
    header = json.loads(str(arrays.pop("header")))
    change(header, arrays)
    np.savez(path, header=np.array(json.dumps(header)), **arrays)
    with pytest.raises(InputError, match=message):
        load_model(path)
