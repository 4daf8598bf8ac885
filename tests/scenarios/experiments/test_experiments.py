"""The experiments: writers and people by chance, films kept once made, verdicts; the camera only stood in for."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from vipr.scenarios.command import main
from vipr.scenarios.experiments import films
from vipr.scenarios.experiments import graffiti as letters
from vipr.scenarios.experiments import instruction_trial as trial
from vipr.scenarios.experiments.films import RATE, film
from vipr.scenarios.experiments.instructions import GARBAGE, LANGUAGE, POINTING, Person, idle, perform
from vipr.scenarios.experiments.writers import Writer, draw, graffiti, timed
from vipr.systems import sources


def test_a_hand_slows_down_where_the_curve_turns():
    turn = np.linspace(0.0, np.pi, 200)
    curve = np.column_stack(
        [2.0 * np.cos(turn), 0.5 * np.sin(turn)]
    )  # an ellipse is sharp at its ends, flat in the middle
    path = timed(curve, 1.0, 100.0)
    speed = np.linalg.norm(np.diff(path, axis=0), axis=1)
    x = 0.5 * (path[1:, 0] + path[:-1, 0])
    assert np.median(speed[np.abs(x) < 0.3]) > 1.5 * np.median(speed[(np.abs(x) > 1.7) & (np.abs(x) < 1.9)])
    assert speed[0] < 0.5 * np.median(speed)


def test_writers_differ_and_each_is_like_himself():
    forms = graffiti()
    assert list(forms) == list("ABCDEFGHIJKLMNOPQRSTUVWXYZ")

    def size(drawings):
        resampled = [
            np.array([np.interp(np.linspace(0, 1, 30), np.linspace(0, 1, len(d)), c) for c in d.T]) for d in drawings
        ]
        return np.std(resampled, axis=0).mean()

    rng = np.random.default_rng(0)
    own = size([draw(Writer.drawn(3), "S", forms["S"][:1], rng) for _ in range(12)])
    others = size([draw(Writer.drawn(k), "S", forms["S"][:1], rng) for k in range(12)])
    assert others > 1.5 * own


def test_the_same_seed_draws_the_same_letters_and_halves_are_even(tmp_path):
    a, b = (letters.sittings(4, "stand-in", rounds=2) for _ in range(2))
    assert [s.file for s in a] == [s.file for s in b]
    assert len({s.file for s in a} | {s.file for s in letters.sittings(5, "stand-in", rounds=2)}) == 20
    table = letters.drawings(film(a, tmp_path))
    chosen = letters.halves(table, 0)
    assert abs(chosen.sum() - len(table) / 2) <= 1


@pytest.fixture
def counted(monkeypatch):
    """How often the stand-in camera was used."""
    calls, real = [], films._stand_in
    monkeypatch.setattr(films, "_stand_in", lambda *a: calls.append(1) or real(*a))
    return calls


def test_films_are_kept_once_made_and_go_on_where_they_stopped(tmp_path, counted):
    planned = letters.sittings(1, "stand-in", rounds=1)
    film(planned[:2], tmp_path)
    ticks = []
    reels = film(planned[:3], tmp_path, tick=ticks.append)
    assert len(counted) == 3
    assert ticks[0] == 52 and sum(ticks) == 78
    again = film(planned[:3], tmp_path)
    assert len(counted) == 3
    np.testing.assert_array_equal(reels[0].positions[5], again[0].positions[5])
    (tmp_path / planned[0].file).write_bytes(b"half a f")
    film(planned[:1], tmp_path)
    assert len(counted) == 4


def test_films_of_other_code_or_models_are_made_anew(tmp_path, monkeypatch, counted):
    package = tmp_path / "a_tracker"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "mesh.obj").write_text("v 0 0 0\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(films.MADE_BY, "stand-in", (*films.MADE_BY["stand-in"], package.name))
    planned = letters.sittings(1, "stand-in", rounds=1)[:1]
    folder = films.cache_folder(tmp_path / "cache")
    film(planned, folder)
    sources.digest_of_modules.cache_clear()  # as in a new process
    film(planned, folder)
    assert len(counted) == 1
    (package / "mesh.obj").write_text("v 0 0 1\n")
    sources.digest_of_modules.cache_clear()
    film(planned, folder)
    assert len(counted) == 2


def test_what_a_film_is_made_of_holds_all_that_filming_loads():
    code = (  # every module of this package that filming and tracking import
        "import sys, vipr.scenarios.people.film; "
        "print(*(m for m in sys.modules if m.startswith('vipr.') and hasattr(sys.modules[m], '__file__')))"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    known = films.MADE_BY["rendered"]
    assert "vipr.systems.hands.tracks" in loaded
    missing = {m for m in loaded if not any(m == k or m.startswith(f"{k}.") or k.startswith(f"{m}.") for k in known)}
    assert missing <= {f"vipr.systems.{m}" for m in ("signals", "errors", "timing", "sources", "compiled")}


def test_letters_are_cut_where_they_begin_and_end(tmp_path):
    (reel,) = film(letters.sittings(1, "stand-in", rounds=1)[:1], tmp_path)
    table = letters.drawings([reel])
    first, last = np.array([t.times[[0, -1]] for t in table.trajectories]).T
    assert np.median(np.abs(first - reel.bounds[:, 0] / RATE)) < 0.2
    assert np.median(np.abs(last - reel.bounds[:, 1] / RATE)) < 0.2


def test_a_letter_is_read_from_the_face_s_track_where_that_follows_the_hand(tmp_path):
    (reel,) = film(letters.sittings(1, "stand-in", rounds=1)[:1], tmp_path)
    mistaken = replace(reel, positions=[p[:, ::-1] for p in reel.positions], seen=[s[:, ::-1] for s in reel.seen])
    for ours, theirs in zip(*(letters.drawings([r]).trajectories for r in (reel, mistaken)), strict=True):
        np.testing.assert_array_equal(ours.points, theirs.points)


def test_the_beginning_of_a_letter_is_not_lost_with_the_film_s(tmp_path):
    (reel,) = film(letters.sittings(1, "stand-in", rounds=1)[:1], tmp_path)
    first = np.array([t.times[0] for t in letters.drawings([reel]).trajectories])
    assert np.mean(first < 1.5 / RATE) > 0.5


def test_a_letter_that_is_not_yet_at_rest_when_its_film_ends_is_whole(tmp_path):
    (reel,) = film(letters.sittings(1, "stand-in", rounds=1)[:1], tmp_path)
    ends = reel.bounds[:, 1] + 1
    cut = {name: [t[:n] for t, n in zip(getattr(reel, name), ends, strict=True)] for name in ("positions", "seen")}
    last = np.array([t.times[-1] for t in letters.drawings([replace(reel, **cut)]).trajectories])
    assert np.abs(last - reel.bounds[:, 1] / RATE).max() < 0.2


@pytest.mark.parametrize("name", LANGUAGE)
def test_every_gesture_can_be_made_and_some_point(name):
    rng = np.random.default_rng(2)
    path, target = perform(Person.drawn(1), name, rng)
    hands = [h for h in (path.right, path.left) if h is not None]
    assert all(np.isfinite(h).all() and np.linalg.norm(h, axis=1).max() < 1.0 for h in hands)
    assert np.isfinite(target).all() == (name in POINTING)


def test_idle_hands_are_of_many_kinds():
    rng = np.random.default_rng(3)
    assert len({idle(Person.drawn(1), rng)[1] for _ in range(60)}) == 8


@pytest.fixture(scope="module")
def language(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cache")
    training, test = (film(trial.sittings(part, 1, "stand-in", 0.15), folder) for part in (False, True))
    return trial.train_language(training, updates=60), test


def test_instructions_of_unseen_people_are_known_and_idle_hands_are_not(language):
    outcome = trial.try_language(*language)
    rates = trial.rates(outcome)
    assert rates["recognised_percent"] > 75.0
    assert rates["false_acceptance_percent"] < 25.0
    assert np.nanmedian(outcome.angle) < np.deg2rad(15.0)
    assert np.nanmedian(outcome.delay) <= 0.2  # s


def test_rejection_grows_with_the_threshold_and_acceptance_falls(language):
    rejected, accepted = trial.curve(trial.try_language(*language))
    assert (np.diff(rejected) >= -1e-9).all() and (np.diff(accepted) <= 1e-9).all()
    assert accepted[-1] == 0.0 and rejected[-1] == 100.0


def test_the_command_writes_table_two_and_its_pictures(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(letters, "ROWS", {"combined": letters.ROWS["combined"]})
    arguments = ["experiment", "graffiti", "--camera", "stand-in", "--alphabets", "2", "--json"]
    with pytest.raises(SystemExit) as left:
        main([*arguments, "--cache", str(tmp_path / "cache"), "--out", str(tmp_path / "out")])
    assert left.value.code == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["sequences"] == 260 and summary["camera"] == "stand-in"
    assert summary["rows"]["combined"]["known_percent"] > 90.0
    each = summary["rows"]["combined"]["unseen_percent_by_writer"]
    assert list(each) == [f"writer {k}" for k in range(1, 6)]
    assert np.mean(list(each.values())) == pytest.approx(summary["rows"]["combined"]["unseen_percent"], abs=0.01)
    assert json.loads((tmp_path / "out" / "summary.json").read_text()) == summary
    assert (tmp_path / "out" / "confusion_combined_unseen.png").exists()


def test_an_unknown_camera_is_one_line(tmp_path, capsys):
    for name in ("graffiti", "instructions"):
        with pytest.raises(SystemExit) as left:
            main(["experiment", name, "--camera", "eye", "--out", str(tmp_path)])
        assert left.value.code == 2
        assert "--camera is rendered or stand-in, got 'eye'" in capsys.readouterr().err


def test_one_alphabet_has_no_half_for_training(tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        main(["experiment", "graffiti", "--alphabets", "1", "--out", str(tmp_path / "out")])
    assert left.value.code == 2
    assert "--alphabets is 0 or at least 2" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_garbage_is_not_a_gesture():
    assert GARBAGE not in LANGUAGE and len(LANGUAGE) >= 10
