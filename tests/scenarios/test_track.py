"""``vipr track``: what it writes, and one clear line for what it cannot use."""

import csv
import json

import av
import cv2
import numpy as np
import pytest
import yaml
from drawn_objects import LENS, box, picture, pose_at

from vipr.scenarios.command import main
from vipr.scenarios.followed import FIELDS, Target
from vipr.scenarios.recorded_tracking import track_images
from vipr.systems import se3
from vipr.systems.camera.image_files import ImageSequence, list_images, read_image
from vipr.systems.errors import InputError
from vipr.systems.tracking.evaluation import compare, corner_distances, read_pose, read_poses

FRAMES = 6


@pytest.fixture
def recording(tmp_path):
    """A folder as users have it: images, camera, model, initial pose, reference."""
    folder = tmp_path / "box"
    (folder / "images").mkdir(parents=True)
    for k in range(FRAMES):
        cv2.imwrite(str(folder / "images" / f"{k}.png"), picture(box(), pose_at(0.04 * k)))
    camera = {
        "image_width": LENS.width,
        "image_height": LENS.height,
        "camera_matrix": {"data": LENS.K.ravel().tolist()},
    }
    (folder / "camera.yaml").write_text(yaml.safe_dump(camera))
    vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in box().vertices)
    (folder / "object.obj").write_text(
        vertices + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in box().triangles)
    )
    (folder / "initial-pose.yaml").write_text(yaml.safe_dump({"X_CO": pose_at(0.0).tolist()}))
    rows = [",".join(("frame", *FIELDS[2:18]))]
    rows += [",".join(map(str, (k, *pose_at(0.04 * k).ravel()))) for k in range(FRAMES)]
    (folder / "reference.csv").write_text("\n".join(rows))
    return folder


def arguments(folder, out, **changes):
    options = {
        "images": folder / "images" / "*.png",
        "model": folder / "object.obj",
        "camera": folder / "camera.yaml",
        "initial-pose": folder / "initial-pose.yaml",
        "out": out,
    } | {k.replace("_", "-"): v for k, v in changes.items()}
    return ["track", *(word for k, v in options.items() for word in ((f"--{k}",) if v is True else (f"--{k}", str(v))))]


def run(words):
    """Exit code of the command."""
    with pytest.raises(SystemExit) as end:
        main(words)
    return end.value.code or 0


def test_it_writes_poses_video_and_summary(recording, tmp_path, capsys):
    out = tmp_path / "out"
    assert run(arguments(recording, out, reference=recording / "reference.csv", json=True)) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary == json.loads((out / "summary.json").read_text())
    assert (summary["frames"], summary["tracking"], summary["complete"]) == (FRAMES, FRAMES, True)
    assert summary["agreement"]["followed"] == FRAMES and summary["agreement"]["corner_px"]["max"] < 1
    with open(out / "poses.csv") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == FIELDS and len(rows) == FRAMES
    assert [row["time_s"] for row in rows[:2]] == ["0.000000", "0.040000"]
    assert np.allclose(read_poses(out / "poses.csv")[3], pose_at(0.12), atol=5e-3)
    with av.open(str(out / "overlay.mp4")) as video:
        pictures = [frame.to_ndarray(format="bgr24") for frame in video.decode(video=0)]
    assert len(pictures) == FRAMES
    green = pictures[3].astype(int)
    assert ((green[..., 1] - green[..., 2]) > 60).sum() > 50  # the model is drawn
    assert sorted(p.name for p in out.iterdir()) == ["overlay.mp4", "poses.csv", "summary.json"]


def test_several_objects_are_followed_at_once_each_with_a_table_of_its_own(recording, tmp_path, capsys):
    left, right = (se3.pose(np.eye(3), [x, 0.0, 0.15]) for x in (-0.09, 0.09))
    truth = [(left @ pose_at(0.04 * k), right @ pose_at(0.0)) for k in range(FRAMES)]
    for k, poses in enumerate(truth):
        cv2.imwrite(str(recording / "images" / f"{k}.png"), np.maximum(*(picture(box(), X) for X in poses)))
    for name, X_CO in zip(("initial-pose", "beside"), truth[0], strict=True):
        (recording / f"{name}.yaml").write_text(yaml.safe_dump({"X_CO": X_CO.tolist()}))
    words, out = arguments(recording, tmp_path / "out"), tmp_path / "out"
    another = ["--model", str(recording / "object.obj"), "--initial-pose", str(recording / "beside.yaml")]
    assert run([*words, *another]) == 0
    assert "object-2: 6 frames: 6 tracking" in capsys.readouterr().out
    files = ["overlay.mp4", "poses-object-2.csv", "poses-object.csv", "summary.json"]
    assert sorted(p.name for p in out.iterdir()) == files
    summary = json.loads((out / "summary.json").read_text())
    assert [one["tracking"] for one in summary["objects"]] == [FRAMES, FRAMES] and summary["complete"]
    for file, X_CO in zip(("poses-object.csv", "poses-object-2.csv"), truth[-1], strict=True):
        assert np.allclose(read_poses(out / file)[FRAMES - 1], X_CO, atol=1e-2)
    assert run([*words, *another[:2]]) == 2
    assert "got 2 models, 1 initial poses, 0 references" in capsys.readouterr().err


def test_without_video_none_is_written_and_settings_are_obeyed(recording, tmp_path, capsys):
    out = tmp_path / "out"
    assert run([*arguments(recording, out, no_video=True, set="texture=false"), "--set", "nodes=50"]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["settings"]["texture"], summary["settings"]["nodes"]) == (False, 50)
    assert not (out / "overlay.mp4").exists()
    assert "6 tracking" in capsys.readouterr().out


def spoil(folder, part):
    if part == "truncated":
        path = folder / "images" / "3.png"
        path.write_bytes(path.read_bytes()[:-40])
    elif part == "size":
        cv2.imwrite(str(folder / "images" / "3.png"), np.zeros((20, 20), np.uint8))
    elif part == "intrinsics":
        (folder / "camera.yaml").write_text("image_width: 160\nimage_height: 120\n")
    elif part == "faces":
        (folder / "object.obj").write_text("v 0 0 0\n")
    elif part == "behind":
        (folder / "initial-pose.yaml").write_text(yaml.safe_dump({"X_CO": se3.pose(np.eye(3), [0, 0, -1.0]).tolist()}))
    elif part == "nan":
        (folder / "initial-pose.yaml").write_text("X_CO: [.nan, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1]\n")
    elif part == "images":
        for path in (folder / "images").iterdir():
            path.unlink()


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ("truncated", "3.png: is truncated"),
        ("size", "image 3.png is 20 x 20 px, the camera file says 160 x 120 px"),
        ("intrinsics", "needs image_width, image_height and camera_matrix"),
        ("faces", "has no faces"),
        ("behind", "must be in front of the camera"),
        ("nan", "finite rigid motion"),
        ("images", "found none"),
    ],
)
def test_bad_input_is_one_line_and_leaves_earlier_results_alone(recording, tmp_path, capsys, part, message):
    out = tmp_path / "out"
    out.mkdir()
    (out / "poses.csv").write_text("good")
    spoil(recording, part)
    assert run(arguments(recording, out)) == 2
    error = capsys.readouterr().err.strip().splitlines()
    assert len(error) == 1 and message in error[0]
    assert (out / "poses.csv").read_text() == "good"
    assert [p.name for p in out.iterdir()] == ["poses.csv"]


def test_a_bad_image_can_be_taken_as_a_dropped_frame(recording, tmp_path):
    spoil(recording, "truncated")
    out = tmp_path / "out"
    assert run(arguments(recording, out, skip_bad=True)) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["skipped"], summary["tracking"], summary["uncertain"]) == (["3.png"], FRAMES - 1, 1)


def test_a_misspelt_setting_is_named(recording, tmp_path, capsys):
    assert run(arguments(recording, tmp_path / "out", set="textures=false")) == 2
    assert "texture" in capsys.readouterr().err


def test_what_is_interrupted_keeps_what_it_has(recording, tmp_path):
    def stop(frame, state):
        if frame == 2:
            raise KeyboardInterrupt

    out = tmp_path / "out"
    out.mkdir()
    with pytest.raises(KeyboardInterrupt):
        track_images(ImageSequence(str(recording / "images")), [Target(box(), pose_at(0.0))], LENS, out, progress=stop)
    assert len(read_poses(out / "poses.csv")) == 3
    assert not json.loads((out / "summary.json").read_text())["complete"]
    assert (out / "overlay.mp4").stat().st_size > 0


def test_images_come_in_natural_order_from_folders_globs_patterns_and_videos(tmp_path):
    for k in (10, 2, 1):
        cv2.imwrite(str(tmp_path / f"img{k}.png"), np.full((8, 8), 10 * k, np.uint8))
    (tmp_path / "notes.txt").write_text("not an image")
    for spec in (tmp_path, tmp_path / "*.png", tmp_path / "img%d.png"):
        assert [p.name for p in list_images(str(spec))] == ["img1.png", "img2.png", "img10.png"]
    assert [int(image[0, 0]) for _, image in ImageSequence(str(tmp_path))] == [10, 20, 100]
    with pytest.raises(InputError, match="found none"):
        list_images(str(tmp_path / "*.jpg"))


def test_images_of_sixteen_bits_and_with_transparency_are_read(tmp_path):
    cv2.imwrite(str(tmp_path / "deep.png"), np.full((4, 4), 0x8000, np.uint16))
    cv2.imwrite(str(tmp_path / "clear.png"), np.full((4, 4, 4), 77, np.uint8))
    assert read_image(tmp_path / "deep.png")[0, 0] == 128
    assert read_image(tmp_path / "clear.png").shape == (4, 4, 3)


@pytest.mark.parametrize("text", ["X_CO: [1, 2, 3]", "X_CO: {}", "- a", "", "X_CO: hello", "{"])
def test_a_pose_file_says_what_it_wants(tmp_path, text):
    path = tmp_path / "pose.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=r"pose\.yaml"):
        read_pose(path)


def test_poses_may_be_given_as_six_numbers(tmp_path):
    path = tmp_path / "pose.pos"
    path.write_text("0.1\n0.2\n0.8\n0.0\n0.0\n1.5\n")
    assert np.allclose(read_pose(path), se3.pose(se3.exp_so3(np.array([0, 0, 1.5])), np.array([0.1, 0.2, 0.8])))


def test_agreement_counts_frames_until_the_first_that_is_not_followed():
    truth = {k: pose_at(0.0) for k in range(5)}
    poses = dict(truth)
    poses[3] = se3.pose(truth[3][:3, :3], truth[3][:3, 3] + (0.05, 0, 0))
    result = compare(box(), LENS, poses, truth, {k: "tracking" for k in range(5)})
    assert (result.frames, result.followed, result.lost_at, result.false_tracking) == (5, 3, 3, 1)
    assert result.translation_mm.max == pytest.approx(50) and result.corner_px.median == 0
    assert corner_distances(box(), LENS, truth[0], poses[3]).mean() > 20
    with pytest.raises(InputError, match="no frame in common"):
        compare(box(), LENS, poses, {9: truth[0]})


@pytest.mark.parametrize(
    ("name", "median", "p90"), [("mbt_cube", 1.04, 1.65), ("teabox", 1.74, 1.88), ("blender_teabox", 0.70, 0.97)]
)
def test_real_recordings_are_followed_as_well_as_by_the_best(shared_data, tmp_path, name, median, p90):
    """To the last frame, and no further from the reference than ViSP's edge tracker."""
    folder = shared_data / "tracking" / name
    out = tmp_path / "out"
    words = arguments(folder, out, images=folder / "images", reference=folder / "reference.csv", no_video=True)
    assert run(words) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert summary["tracking"] == summary["frames"]
    assert summary["agreement"]["lost_at"] is None
    assert summary["agreement"]["corner_px"]["median"] <= median and summary["agreement"]["corner_px"]["p90"] <= p90


BLIND = """
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem

from vipr.systems.signals import CameraFrame, ObjectPose


class Blind(LeafSystem):
    def __init__(self, model, lens, *, X_CO_initial=None, settings=None, period=0.04, offset=0.0):
        super().__init__()
        self.DeclareAbstractInputPort("frame", Value(CameraFrame()))
        self.DeclareAbstractOutputPort("object_pose", lambda: Value(ObjectPose()), lambda context, output: None)


class Deaf(Blind):
    def __init__(self, *arguments, **settings):
        LeafSystem.__init__(self)
"""


def test_a_tracker_of_the_users_own_is_tried_on_the_same_images(recording, tmp_path, capsys):
    (tmp_path / "blind.py").write_text(BLIND)
    out, place = tmp_path / "out", f"tracker={tmp_path / 'blind.py'}"
    assert run([*arguments(recording, out, stage=f"{place}:Blind"), "--no-video"]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["lost"], summary["tracking"]) == (FRAMES, 0) and summary["stages"]["tracker"].endswith(":Blind")
    capsys.readouterr()
    for stage, message in (
        (f"{place}:Deaf", "Deaf has no input port 'frame'"),
        ("tracker", "--stage tracker: expected NAME=FILE.py:CLASS"),
        (f"eye{place.removeprefix('tracker')}:Blind", "unknown stage 'eye'; those that can be replaced are tracker"),
    ):
        assert run(arguments(recording, out, stage=stage)) == 2
        error = capsys.readouterr().err
        assert message in error and len(error.split("\n")) <= 3
