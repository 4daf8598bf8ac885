"""Frames with their times from a video file, a camera or image files: what a recorded or live camera gives, one by one."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from vipr.systems.camera.image_files import list_images, read_image
from vipr.systems.errors import InputError


@dataclass(frozen=True)
class FrameSource:
    """An opened source: its frames as (image, time [s]), how many it claims to have (0: unknown) and its nominal rate."""

    name: str
    frames: Iterator[tuple[np.ndarray, float]]
    count: int
    rate: float  # images/s
    note: str = ""  # what was assumed, for the summary


def open_images(spec: str, rate: float = 25.0) -> FrameSource:
    """Image files (folder, quoted glob, pattern) as a sequence at ``rate`` images/s."""
    _check_rate(rate)
    files = list_images(spec)
    return FrameSource(spec, ((read_image(path), k / rate) for k, path in enumerate(files)), len(files), rate)


def open_video(path: Path, rate: float | None = None) -> FrameSource:
    """A video file at its own time stamps; ``rate`` images/s replaces them where given."""
    import av

    if not path.is_file():
        raise InputError(f"video {path}: no such file")
    try:
        with av.open(str(path)) as container:
            if not container.streams.video:
                raise InputError(f"video {path}: holds no video stream")
            stream = container.streams.video[0]
            nominal, count = float(stream.average_rate or stream.guessed_rate or 0.0), stream.frames
    except (av.error.FFmpegError, OSError, IndexError) as error:
        raise InputError(f"video {path}: cannot be opened ({_reason(error)})") from None
    note = ""
    if rate is None and not (np.isfinite(nominal) and 0.1 <= nominal <= 1000):
        rate, note = 25.0, f"the file states {nominal:g} frames/s; 25 frames/s assumed"
    if rate is not None:
        _check_rate(rate)
    return FrameSource(str(path), _decode(path, rate, nominal), count, rate or nominal, note)


def _decode(path: Path, rate: float | None, nominal: float) -> Iterator[tuple[np.ndarray, float]]:
    import av

    k, last, start = -1, -np.inf, None
    try:
        with av.open(str(path)) as container:
            container.streams.video[0].thread_type = "AUTO"
            for k, frame in enumerate(container.decode(video=0)):
                if rate is not None or frame.time is None:
                    time = k / (rate or nominal)
                else:
                    start = frame.time if start is None else start
                    time = frame.time - start
                    if time <= last:  # broken stamps: go on at the nominal rate
                        time = last + 1.0 / nominal
                last = time
                yield _upright(frame.to_ndarray(format="bgr24"), getattr(frame, "rotation", 0)), float(time)
    except (av.error.FFmpegError, OSError) as error:
        if k < 0:
            raise InputError(f"video {path}: no frame can be decoded ({_reason(error)})") from None
    if k < 0:
        raise InputError(f"video {path}: holds no frames")


def _upright(image: np.ndarray, degrees: int) -> np.ndarray:
    """The image as a player would show it; ``degrees`` counter-clockwise, as the container states them."""
    turn = {90: cv2.ROTATE_90_COUNTERCLOCKWISE, 180: cv2.ROTATE_180, 270: cv2.ROTATE_90_CLOCKWISE}.get(degrees % 360)
    return image if turn is None else cv2.rotate(image, turn)


def open_camera(number: int, rate: float | None = None) -> FrameSource:
    """A live camera by its number."""
    import time

    capture = cv2.VideoCapture(number)
    if number < 0 or not capture.isOpened():
        raise InputError(f"--camera {number}: no such camera can be opened")
    nominal = rate or capture.get(cv2.CAP_PROP_FPS) or 25.0

    def frames():
        begin = time.monotonic()
        try:
            while True:
                arrived, image = capture.read()
                if not arrived:
                    return
                yield image, time.monotonic() - begin
        finally:
            capture.release()

    return FrameSource(f"camera {number}", frames(), 0, float(nominal))


def _check_rate(rate: float) -> None:
    if not (np.isfinite(rate) and 0 < rate <= 1000):
        raise InputError(f"--fps: must be above 0 and at most 1000 frames/s, got {rate:g}")


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or (str(error).splitlines() or [type(error).__name__])[0]
