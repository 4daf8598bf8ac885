"""``vipr calibrate``: simulated views, the same images again as recordings, and what it refuses."""

import json
import shutil

import numpy as np
import pytest

from vipr.scenarios.command import main
from vipr.systems.calibration.files import read_calibration


def command(*arguments):
    with pytest.raises(SystemExit) as end:
        main(["calibrate", *map(str, arguments)])
    return end.value.code


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """A calibration from nine simulated views."""
    folder = tmp_path_factory.mktemp("calibration")
    assert command("--seed", 5, "--views", 9, "--other-camera", "--out", folder) == 0
    return folder


def test_the_errors_against_truth_are_within_what_was_told(simulated):
    told = json.loads((simulated / "summary.json").read_text())
    wrong = told["error_against_truth"]
    for name, sigma in told["intrinsics_standard_error"].items():
        assert abs(wrong[name]) < 4 * sigma
    assert (np.abs(wrong["position_mm"]) < 4 * np.array(told["position_standard_error_mm"])).all()
    assert (np.abs(wrong["rotation_deg"]) < 4 * np.array(told["rotation_standard_error_deg"])).all()
    assert told["views"] == 9 and told["rms_px"] < 0.12
    assert abs(wrong["fx"]) < 0.01 * told["intrinsics"]["fx"]
    assert (simulated / "residuals.png").stat().st_size > 10_000


def test_the_written_images_and_poses_give_the_same_calibration_again(simulated, tmp_path, capsys):
    assert command("--images", simulated / "images", "--poses", simulated / "poses.csv", "--out", tmp_path) == 0
    assert "9 views" in capsys.readouterr().out
    (lens, X_WC), (first_lens, first_X_WC) = read_calibration(tmp_path), read_calibration(simulated)
    assert lens == first_lens and np.array_equal(X_WC, first_X_WC)
    assert "error_against_truth" not in json.loads((tmp_path / "summary.json").read_text())


def test_bad_input_is_refused_in_one_line_and_nothing_is_written(simulated, tmp_path, capsys):
    images, poses, out = simulated / "images", simulated / "poses.csv", tmp_path / "out"
    half = tmp_path / "half.csv"
    half.write_text("\n".join(poses.read_text().splitlines()[:4]) + "\n")
    broken = tmp_path / "broken.csv"
    broken.write_text(poses.read_text().replace("view_03.png,", "view_03.png,x"))
    few = tmp_path / "few"
    few.mkdir()
    for k in range(3):
        shutil.copy(images / f"view_0{k}.png", few)
    board = tmp_path / "board.yaml"
    board.write_text("kind: charuco\ncolumns: 9\nrows: 5\nsquare_mm: 34\nmarker_mm: 50\n")
    for arguments, said in (
        ((), "give either --seed, for simulated views, or --images with --poses"),
        (("--images", images), "--images needs --poses"),
        (("--seed", 1, "--poses", poses), "--poses and --board belong to --images"),
        (("--seed", 1, "--views", 2), "--views must be 4 to 200, got 2"),
        (("--images", images, "--poses", half), "has no pose for image view_03.png"),
        (("--images", images, "--poses", broken), "line 5: needs the columns image, x_we_00"),
        (("--images", images, "--poses", tmp_path / "none.csv"), "cannot be read"),
        (("--images", few, "--poses", poses), "needs at least 4 views that show the board, got 3"),
        (("--images", images, "--poses", poses, "--board", board), "markers must be above 0 and below"),
        (("--images", images, "--poses", poses, "--radial", 3), "0, 1 or 2 coefficients"),
        (("--images", images, "--poses", poses, "--arm-mm", 0), "position_mm must be 1e-6 to 1000, got 0"),
    ):
        assert command(*arguments, "--out", out) == 2
        error = capsys.readouterr().err.strip()
        assert said in error and error.startswith("vipr: error: ") and "\n" not in error
        assert not out.exists() or not any(out.iterdir())
