"""``log.mcap``: everything a run records in Foxglove's schemas, which Foxglove, Rerun and ROS 2 tools open.

Topics: ``/<channel>`` for each channel, ``/tf`` and ``/tf_static`` for the frames, ``/events``. Times are simulated, from 0. Each tick ends
its chunk of the file and hands it to the system, so that a killed run's log holds every finished tick (it lacks the index at the
end, which readers rebuild).
"""

import math
from pathlib import Path

import cv2
import foxglove
import numpy as np
from foxglove import channels as typed
from foxglove.mcap import MCAPCompression, MCAPWriteOptions
from foxglove.messages import (
    CompressedImage,
    FrameTransform,
    FrameTransforms,
    JointState,
    JointStates,
    Log,
    LogLevel,
    Pose,
    PoseInFrame,
    Quaternion,
    Timestamp,
    Vector3,
)

from vipr.systems.recording.channels import (
    Channel,
    Event,
    ImageChannel,
    JointChannel,
    PoseChannel,
    StatusChannel,
    VectorChannel,
)
from vipr.systems.recording.files import cannot_be_written
from vipr.systems.se3 import log_so3

LEVELS = {"info": LogLevel.Info, "warning": LogLevel.Warning, "error": LogLevel.Error}
QUALITY = ("nodes", "residual_px", "score")  # of a tracked pose, on /<channel>/quality


class RunLog:
    """Writes an MCAP file tick by tick.

    Args:
        path: the file; an existing one is overwritten.
        channels: what will be written.
        frames: poses that never change, ``{(parent, child): X_PC (4, 4)}``.
    """

    def __init__(self, path: Path, channels: tuple[Channel, ...], frames: dict | None = None):
        self._file = _Unbuffered(path)
        self._context = foxglove.Context()  # its own: two logs in one program do not mix
        self._writer = foxglove.open_mcap(
            self._file,
            context=self._context,
            writer_options=MCAPWriteOptions(
                profile="", compression=MCAPCompression.Zstd, compression_threads=0, chunk_size=None
            ),
        )
        self._channels = {channel.name: channel for channel in channels}
        self._topics = {}
        for channel in channels:
            self._open(channel)
        self._tf = self._typed(typed.FrameTransformsChannel, "tf")
        self._events = self._typed(typed.LogChannel, "events")
        self._image_numbers = {}
        if frames:
            static = self._typed(typed.FrameTransformsChannel, "tf_static")
            static.log(_transforms([(*names, X) for names, X in frames.items()], 0.0), log_time=0)

    def write(self, time: float, values: dict, events: list[Event] = ()) -> None:
        """Append a tick: values by channel name, as `RunFolder.record` takes them, and the events of the tick."""
        transforms = []
        for name, value in values.items():
            channel = self._channels[name]
            if isinstance(channel, ImageChannel):
                self._image(channel, value)
            elif isinstance(channel, PoseChannel):
                X = value.X_CO if channel.tracked else value
                if known(channel, value):
                    self._log(name, PoseInFrame(timestamp=stamp(time), frame_id=channel.parent, pose=_pose(X)), time)
                    transforms.append((channel.parent, channel.frame, X))
                if channel.tracked:
                    self._log(f"{name}/quality", {q: _number(getattr(value, q)) for q in QUALITY}, time)
            elif isinstance(channel, JointChannel):
                self._log(name, _joints(channel, value, time), time)
            elif isinstance(channel, VectorChannel):
                self._log(name, {n: _number(v) for n, v in zip(channel.names, value, strict=True)}, time)
        if transforms:
            self._tf.log(_transforms(transforms, time), log_time=nanoseconds(time))
        for event in events:
            message = Log(timestamp=stamp(event.time), level=LEVELS[event.level], message=event.text, name=event.source)
            self._events.log(message, log_time=nanoseconds(event.time))
        self._finish(self._writer.flush)

    def close(self) -> None:
        """Write the index and close the file."""
        try:
            self._finish(self._writer.close)
        finally:
            self._file.close()

    def _finish(self, act) -> None:
        try:
            act()
        except Exception:
            self._file.check()  # the file's own error says what happened
            raise
        self._file.check()

    def _open(self, channel: Channel) -> None:
        name = channel.name
        if isinstance(channel, ImageChannel):
            self._topics[name] = self._typed(typed.CompressedImageChannel, name)
        elif isinstance(channel, PoseChannel):
            self._topics[name] = self._typed(typed.PoseInFrameChannel, name)
            if channel.tracked:
                self._topics[f"{name}/quality"] = self._json(f"{name}/quality", QUALITY, ("", "px", ""))
        elif isinstance(channel, JointChannel):
            self._topics[name] = self._typed(typed.JointStatesChannel, name)
        elif isinstance(channel, VectorChannel):
            self._topics[name] = self._json(name, channel.names, channel.units)
        elif not isinstance(channel, StatusChannel):  # whose changes are events
            raise TypeError(f"{name}: no way to log a {type(channel).__name__}")

    def _typed(self, kind, name: str):
        return kind(f"/{name}", context=self._context)

    def _json(self, name: str, names, units):
        fields = {
            n: {"type": ["number", "null"], "description": f"[{u or '1'}]"} for n, u in zip(names, units, strict=True)
        }
        schema = {"title": f"vipr.{name.replace('/', '.')}", "type": "object", "properties": fields}
        return foxglove.Channel(f"/{name}", schema=schema, context=self._context)

    def _log(self, name: str, message, time: float) -> None:
        self._topics[name].log(message, log_time=nanoseconds(time))

    def _image(self, channel: ImageChannel, frame) -> None:
        if not frame.arrived or frame.number == self._image_numbers.get(channel.name):
            return
        self._image_numbers[channel.name] = frame.number
        if frame.number % channel.every:
            return
        _, jpeg = cv2.imencode(".jpg", frame.image, [cv2.IMWRITE_JPEG_QUALITY, channel.quality])
        message = CompressedImage(
            timestamp=stamp(frame.time), frame_id=channel.frame, format="jpeg", data=jpeg.tobytes()
        )
        self._log(channel.name, message, frame.time)


class _Unbuffered:
    """The file below the log. The SDK only prints what goes wrong with it: here the first error is kept and `check` raises it."""

    def __init__(self, path: Path):
        self.path, self.error, self.whole = path, None, 0  # whole: size up to the last finished tick
        try:
            self._file = open(path, "wb", buffering=0)
        except OSError as error:
            raise cannot_be_written(path, error) from None

    def write(self, data) -> int:
        return self._try(self._write, data)

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._try(self._file.seek, offset, whence)

    def flush(self) -> None:
        """Nothing is held back."""

    def close(self) -> None:
        """Close it, after an error without the piece of a tick that still went in."""
        if self.error is not None and self._file.seekable():
            self._file.truncate(self.whole)
        self._file.close()

    def check(self) -> None:
        """Raise the first error; without one, all that was written is whole."""
        if self.error is not None:
            raise cannot_be_written(self.path, self.error)
        self.whole = self._file.tell()

    def _write(self, data) -> int:
        view = memoryview(data)
        written = 0
        while written < len(view):
            written += self._file.write(view[written:])
        return written

    def _try(self, act, *arguments) -> int:
        try:
            return act(*arguments)
        except OSError as error:
            self.error = self.error or error
            raise


def known(channel: PoseChannel, value) -> bool:
    """Whether a pose channel's value is a pose: finite, and not of a lost track."""
    return bool(
        np.isfinite(value.X_CO).all() and value.state != "lost" if channel.tracked else np.isfinite(value).all()
    )


def nanoseconds(time: float) -> int:
    """Simulated time [s] as whole nanoseconds."""
    return max(0, round(time * 1e9))


def stamp(time: float) -> Timestamp:
    """Simulated time [s] as a message's time stamp."""
    seconds, rest = divmod(nanoseconds(time), 10**9)
    return Timestamp(sec=seconds, nsec=rest)


def _number(value) -> float | None:
    return float(value) if math.isfinite(value) else None


def _rotation(X: np.ndarray) -> Quaternion:
    w = log_so3(X[:3, :3])
    half = 0.5 * float(np.linalg.norm(w))
    x, y, z = (float(v) for v in w * (0.5 * np.sinc(half / np.pi)))
    return Quaternion(x=x, y=y, z=z, w=math.cos(half))


def _translation(X: np.ndarray) -> Vector3:
    return Vector3(x=float(X[0, 3]), y=float(X[1, 3]), z=float(X[2, 3]))


def _pose(X: np.ndarray) -> Pose:
    return Pose(position=_translation(X), orientation=_rotation(X))


def _transforms(poses: list, time: float) -> FrameTransforms:
    at = stamp(time)
    return FrameTransforms(
        transforms=[
            FrameTransform(
                timestamp=at,
                parent_frame_id=parent,
                child_frame_id=child,
                translation=_translation(X),
                rotation=_rotation(X),
            )
            for parent, child, X in poses
        ]
    )


def _joints(channel: JointChannel, values: np.ndarray, time: float) -> JointStates:
    n = len(channel.joints)
    velocities = values[n:] if channel.velocities else [None] * n
    states = [
        JointState(name=name, position=float(q), velocity=None if v is None else float(v))
        for name, q, v in zip(channel.joints, values[:n], velocities, strict=True)
    ]
    return JointStates(timestamp=stamp(time), joints=states)
