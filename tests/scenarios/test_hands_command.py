"""``vipr hands``: what it writes, and one clear line for what it cannot use."""

import csv
import json

import cv2
import numpy as np
import pytest
from drawn_people import FACE, waving

from vipr.scenarios.command import main
from vipr.scenarios.people.clip import COLUMNS, follow_video
from vipr.systems.camera.video_frames import FrameSource, open_video
from vipr.systems.errors import InputError
from vipr.systems.recording.video import VideoWriter

FRAMES = 14


def run(*words):
    """Exit code of the command."""
    with pytest.raises(SystemExit) as end:
        main(["hands", *map(str, words)])
    return end.value.code or 0


@pytest.fixture
def clip(tmp_path):
    path = tmp_path / "clip.mp4"
    with VideoWriter(path, fps=25) as video:
        for k in range(FRAMES):
            video.write(waving(k))
    return path


def source(images, rate=25.0):
    return FrameSource("drawn", ((image, k / rate) for k, image in enumerate(images)), len(images), rate)


def rows(folder):
    with open(folder / "regions.csv", newline="") as file:
        return list(csv.DictReader(file))


def test_a_video_gives_a_table_an_overlay_and_a_summary(clip, tmp_path, capsys):
    out = tmp_path / "out"
    assert run("--video", clip, "--out", out, "--json") == 0
    table, summary = rows(out), json.loads((out / "summary.json").read_text())
    assert tuple(table[0]) == COLUMNS and len(table) == FRAMES
    last = table[-1]
    assert last["face_seen"] == "1" and abs(float(last["face_x"]) - FACE[0]) < 2
    assert float(last["left_x"]) > float(last["face_x"]) > float(last["right_x"])
    assert float(last["time_s"]) == pytest.approx((FRAMES - 1) / 25, abs=0.01) and int(last["area_px"]) > 300
    assert summary["frames"] == FRAMES and summary["complete"] and summary["sizes"] == [[160, 120]]
    assert json.loads(capsys.readouterr().out) == summary
    assert sum(1 for _ in open_video(out / "overlay.mp4").frames) == FRAMES
    assert sorted(p.name for p in out.iterdir()) == ["overlay.mp4", "regions.csv", "summary.json"]


def test_in_a_mirrored_video_left_and_right_are_exchanged(clip, tmp_path):
    assert run("--video", clip, "--out", tmp_path / "a", "--no-video") == 0
    assert run("--video", clip, "--out", tmp_path / "b", "--no-video", "--mirrored") == 0
    a, b = rows(tmp_path / "a")[-1], rows(tmp_path / "b")[-1]
    assert (a["left_x"], a["left_y"]) == (b["right_x"], b["right_y"]) and a["right_x"] == b["left_x"]
    assert not (tmp_path / "a" / "overlay.mp4").exists()


def test_image_files_are_followed_in_natural_order(tmp_path):
    for k in range(11):
        cv2.imwrite(str(tmp_path / f"frame{k}.png"), waving(k))
    assert run("--images", tmp_path / "frame*.png", "--out", tmp_path / "out", "--no-video") == 0
    table = rows(tmp_path / "out")
    assert len(table) == 11 and float(table[10]["time_s"]) == pytest.approx(0.4)


def test_every_kind_of_picture_may_come_and_a_new_size_starts_anew(tmp_path):
    colour = [waving(k) for k in range(6)]
    mixed = [
        *colour,
        np.dstack([colour[0], colour[0][:, :, 0]]),
        colour[1].astype(np.uint16) << 8,
        colour[2].mean(2).astype(np.uint8),
        *[cv2.resize(image, (200, 150)) for image in colour],
    ]
    (tmp_path / "out").mkdir()
    summary = follow_video(source(mixed), tmp_path / "out")
    assert summary["frames"] == len(mixed) and summary["sizes"] == [[160, 120], [200, 150]]
    assert rows(tmp_path / "out")[-1]["face_seen"] == "1"


def test_a_grey_video_is_followed_in_vain_and_says_why(tmp_path):
    (tmp_path / "out").mkdir()
    grey = [waving(k).mean(2).astype(np.uint8) for k in range(4)]
    summary = follow_video(source(grey), tmp_path / "out", video=False)
    assert summary["seen"] == {"face": 0, "left": 0, "right": 0}
    assert summary["notes"] == ["no colour in any frame: skin cannot be told"]
    assert rows(tmp_path / "out")[0]["face_x"] == ""


def one_line(capsys):
    error = capsys.readouterr().err
    assert error.startswith("vipr: error: ") and error.count("\n") == 1 and "Traceback" not in error
    return error


def test_bad_input_is_one_line_and_leaves_nothing(clip, tmp_path, capsys):
    (tmp_path / "empty.mp4").touch()
    (tmp_path / "text.mp4").write_text("this is no video")
    (tmp_path / "cut.mp4").write_bytes(clip.read_bytes()[:300])
    cases = [
        (["--video", tmp_path / "none.mp4"], "no such file"),
        (["--video", tmp_path / "empty.mp4"], "cannot be opened"),
        (["--video", tmp_path / "text.mp4"], "cannot be opened"),
        (["--video", tmp_path / "cut.mp4"], "cut.mp4"),
        (["--video", tmp_path], "no such file"),
        (["--video", clip, "--fps", "0"], "--fps: must be above 0 and at most 1000 frames/s, got 0"),
        (["--video", clip, "--working-area", "5"], "at least 400 px, got 5"),
        (["--images", tmp_path / "*.jpg"], "found none"),
        (["--camera", "77"], "--camera 77: no such camera"),
        ([], "give one of --video"),
        (["--video", clip, "--camera", "0"], "give one of --video"),
    ]
    for words, message in cases:
        out = tmp_path / "out"
        assert run(*words, "--out", out) == 2, words
        assert message in one_line(capsys), words
        assert not out.exists() or not any(out.iterdir()), words


def test_an_unwritable_folder_is_named(clip, tmp_path, capsys):
    (tmp_path / "file").touch()
    assert run("--video", clip, "--out", tmp_path / "file" / "out") == 2
    assert "--out" in one_line(capsys)


def test_a_source_without_frames_leaves_an_earlier_result_alone(tmp_path):
    (tmp_path / "regions.csv").write_text("earlier")
    with pytest.raises(InputError, match="drawn: holds no frames"):
        follow_video(source([]), tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["regions.csv"] and (
        tmp_path / "regions.csv"
    ).read_text() == "earlier"


def test_an_interrupted_run_keeps_what_it_has(tmp_path):
    def frames():
        for k in range(5):
            yield waving(k), k / 25.0
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        follow_video(FrameSource("camera 0", frames(), 0, 25.0), tmp_path)
    assert len(rows(tmp_path)) == 5 and json.loads((tmp_path / "summary.json").read_text())["complete"] is False
    assert sum(1 for _ in open_video(tmp_path / "overlay.mp4").frames) == 5


def test_a_stage_of_the_users_own_is_tried_on_the_same_video(clip, tmp_path, capsys):
    mine = tmp_path / "still.py"
    mine.write_text(
        "from vipr.systems.hands.tracker import HandTracker\n\n\n"
        "class Still(HandTracker):\n    def _update(self, context, state):\n        pass\n"
    )
    out = tmp_path / "out"
    assert run("--video", clip, "--out", out, "--no-video", "--stage", f"hands={mine}:Still", "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["seen"] == {"face": 0, "left": 0, "right": 0} and summary["stages"] == {"hands": f"{mine}:Still"}
    assert run("--video", clip, "--out", out, "--stage", f"feet={mine}:Still") == 2
    assert "unknown stage 'feet'; those that can be replaced are skin, hands" in capsys.readouterr().err
