"""``vipr teach`` and ``vipr run place_by_showing``: the file of a place, its errors, and that the object comes nearer to it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from vipr.diagrams.workcell_layout import fixed_camera
from vipr.models import model_path
from vipr.scenarios.command import main
from vipr.scenarios.place_by_showing import PlaceByShowing, PlaceSettings
from vipr.scenarios.shown_place import ShownPlace, load_shown_place, save_shown_place
from vipr.systems import se3
from vipr.systems.camera.lens import load_lens
from vipr.systems.errors import InputError

LENS = load_lens(model_path("xc77/camera.yaml"))
BOX = np.array([[x, y, z] for x in (-0.04, 0.04) for y in (-0.04, 0.04) for z in (0.0, 0.2)])
X_CO = se3.pose(se3.exp_so3(np.array([1.9, 0.2, 0.1])), [0.02, 0.05, 2.0])
PLACE = ShownPlace("milk_carton", 1, (640, 480), BOX, LENS.project(BOX @ X_CO[:3, :3].T + X_CO[:3, 3]))


def command(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture(scope="module")
def taught(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("teach") / "place.yaml"
    assert command("teach", "--out", path, "--set", "supersampling=1", "--set", "place=4") == 0
    return path


def test_taught_corners_are_where_the_camera_truly_sees_them(taught):
    place = load_shown_place(taught)
    assert (place.object, place.place, place.size) == ("milk_carton", 4, (640, 480))
    scenario = PlaceByShowing(PlaceSettings(place=4), seed=0)
    X = se3.inverse(fixed_camera()) @ scenario.X_WO_shown
    assert np.abs(LENS.project(place.points_O @ X[:3, :3].T + X[:3, 3]) - place.pixels).max() < 1.0


def test_object_comes_to_the_taught_place(taught, tmp_path):
    out = tmp_path / "run"
    brief = ("duration_s=2.5", "supersampling=1", "start_offset_m=0.02", "start_turn_deg=15", "servo.gain=3")
    overrides = [part for setting in (f"shown={taught}", "servo=hybrid", *brief) for part in ("--set", setting)]
    assert command("run", "place_by_showing", "--seed", 2, "--no-video", "--out", out, *overrides) in (0, 1)
    figures = json.loads((out / "summary.json").read_text())["figures"]
    assert figures["final_translation_error_mm"] < 5 and figures["final_rotation_error_deg"] < 1
    assert all(figures[f"joint_{kind}_used_percent"] <= 100.01 for kind in ("position", "speed", "acceleration"))


def test_a_place_comes_back_from_its_file_as_it_was(tmp_path):
    save_shown_place(PLACE, tmp_path / "place.yaml")
    back = load_shown_place(tmp_path / "place.yaml")
    assert np.allclose(back.pixels, PLACE.pixels, atol=1e-3) and np.allclose(back.points_O, BOX)
    task = back.task(LENS, fixed_camera())
    assert np.allclose(task.X_CO_shown, X_CO, atol=1e-4)
    assert back.views(LENS) == (), "no picture was kept"


def test_the_picture_of_a_place_is_kept_beside_its_file_with_the_pose_of_its_corners(tmp_path):
    seen = np.random.default_rng(0).integers(0, 255, (480, 640, 3)).astype(np.uint8)
    save_shown_place(replace(PLACE, picture=seen), tmp_path / "place.yaml")
    (view,) = load_shown_place(tmp_path / "place.yaml").views(LENS)
    assert np.array_equal(view.image, seen) and np.allclose(view.X_CO, X_CO, atol=1e-4)
    (tmp_path / "place.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"shown place: its picture .*place\.png cannot be read"):
        load_shown_place(tmp_path / "place.yaml")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"corners": []}, "4 or more corners of finite numbers are needed, got 0"),
        ({"corners": [{"point_m": [0, 0], "pixel": [1, 2]}] * 5}, "needs object, place, image_size"),
        ({"corners": [{"point_m": [0, 0, ".nan"], "pixel": [1, 2]}] * 5}, "needs object, place, image_size"),
        ({"image_size": [640]}, "needs object, place, image_size"),
    ],
)
def test_a_broken_file_is_refused(tmp_path, change, message):
    path = tmp_path / "place.yaml"
    save_shown_place(PLACE, path)
    path.write_text(yaml.safe_dump({**yaml.safe_load(path.read_text()), **change}))
    with pytest.raises(InputError, match=message):
        load_shown_place(path)


def test_a_place_that_does_not_fit_is_refused():
    with pytest.raises(InputError, match=r"its image is 320 x 240 px, the camera's 640 x 480 px"):
        ShownPlace("milk_carton", 1, (320, 240), BOX, PLACE.pixels).task(LENS, fixed_camera())
    with pytest.raises(InputError, match=r"corners are \d+\.\d px from any view of the object"):
        ShownPlace("milk_carton", 1, (640, 480), BOX, np.roll(PLACE.pixels, 1, axis=0)).task(LENS, fixed_camera())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "shown=nowhere.yaml"], "shown place nowhere.yaml: cannot be read"),
        (["--set", "servo=telepathic"], "setting servo: must be one of position_based, image_based, hybrid"),
        (["--set", "grip_m=1"], "grip_m must be 0 to 0.1, got 1"),
    ],
)
def test_bad_settings_are_one_line(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command("run", "place_by_showing", *arguments) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert not any(tmp_path.iterdir())


def test_a_place_of_another_object_is_refused(taught, capsys):
    assert command("run", "place_by_showing", "--set", f"shown={taught}", "--set", "object=can") == 2
    assert "shows the object 'milk_carton', the setting object is 'can'" in capsys.readouterr().err
