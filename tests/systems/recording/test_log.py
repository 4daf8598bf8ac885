"""What a log holds: every tick in Foxglove's schemas, the values that were recorded, and what was said."""

import json

import cv2
import numpy as np
import pytest
from foxglove.messages import Log, LogLevel, Pose, PoseInFrame, Quaternion, Timestamp, Vector3
from logs_read_back import messages
from mcap.reader import make_reader
from recording_ticks import finished_folder, folder, tick

from vipr.systems.recording.channels import VectorChannel

TICKS = 20


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    return finished_folder(tmp_path_factory.mktemp("runs") / "good")


def test_the_log_holds_every_tick_in_foxglove_schemas(finished):
    found = messages(finished / "log.mcap")
    counts = {topic: len(some) for topic, some in found.items()}
    assert counts == {
        "/camera": TICKS // 2,
        "/X_CO": TICKS - 1,  # lost in the first
        "/X_CO/quality": TICKS,
        "/X_CO_true": TICKS,
        "/servo_error": TICKS,
        "/q": TICKS,
        "/tf": TICKS,
        "/tf_static": 1,
        "/events": 4,
    }
    with open(finished / "log.mcap", "rb") as file:
        index = make_reader(file).get_summary()
    schemas = {c.topic: index.schemas[c.schema_id].name for c in index.channels.values()}
    assert schemas["/camera"] == "foxglove.CompressedImage"
    assert schemas["/X_CO"] == schemas["/X_CO_true"] == "foxglove.PoseInFrame"
    assert schemas["/q"] == "foxglove.JointStates"
    assert schemas["/tf"] == schemas["/tf_static"] == "foxglove.FrameTransforms"
    assert schemas["/events"] == "foxglove.Log"
    assert {c.message_encoding for c in index.channels.values() if schemas[c.topic].startswith("fox")} == {"protobuf"}


def test_poses_in_the_log_are_those_recorded(finished):
    time, data = messages(finished / "log.mcap")["/X_CO_true"][7]
    X = tick(7)["X_CO_true"]
    w = np.array([0.1, 0.14, 0.05])
    angle = np.linalg.norm(w)
    x, y, z = np.sin(angle / 2) * w / angle
    assert time == 280_000_000
    expected = PoseInFrame(
        timestamp=Timestamp(sec=0, nsec=time),
        frame_id="camera",
        pose=Pose(
            position=Vector3(x=X[0, 3], y=X[1, 3], z=X[2, 3]),
            orientation=Quaternion(x=x, y=y, z=z, w=np.cos(angle / 2)),
        ),
    ).encode()
    assert doubles(data) == pytest.approx(doubles(expected), abs=1e-12)


def doubles(data):
    """Position and quaternion at the end of an encoded PoseInFrame: each double follows its one-byte tag."""
    vector, quaternion = 3 * 9, 4 * 9
    packed = np.frombuffer(data[-quaternion:], [("tag", "u1"), ("value", "<f8")])
    before = np.frombuffer(data[-quaternion - 2 - vector : -quaternion - 2], packed.dtype)
    assert list(before["tag"]) + list(packed["tag"]) == [9, 17, 25, 9, 17, 25, 33]
    return [*before["value"], *packed["value"]]


def test_images_in_the_log_decode(finished):
    _, data = messages(finished / "log.mcap")["/camera"][4]
    image = cv2.imdecode(np.frombuffer(data[data.index(b"\xff\xd8\xff") :], np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(image.astype(int) - tick(8)["camera"].image).max() <= 3


def test_numbers_have_names_and_missing_ones_are_null(tmp_path):
    with folder(tmp_path, channels=[VectorChannel("e", ("a", "b"), ("mm", "deg"))]) as run:
        run.record(0.0, {"e": np.array([1.5, np.nan])})
    ((_, data),) = messages(tmp_path / "log.mcap")["/e"]
    assert json.loads(data) == {"a": 1.5, "b": None}


def test_changes_of_state_and_said_things_are_events(finished):
    events = messages(finished / "log.mcap")["/events"]
    said = [
        (0, "phase", "approach"),
        (0.04, "X_CO", "tracking"),
        (0.2, "phase", "hold"),
        (0.5, "scenario", "object starts to move"),
    ]
    for (at, data), (t, name, text) in zip(events, said, strict=True):
        assert at == round(t * 1e9)
        assert data == Log(timestamp=Timestamp(0, at), level=LogLevel.Info, message=text, name=name).encode()
