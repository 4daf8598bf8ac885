"""Recorded images: a folder, a glob, a numbered pattern (``%04d.png``) or a video file, in natural order."""

import re
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from vipr.systems.errors import InputError

IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".tif", ".tiff", ".webp")
VIDEOS = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".mpg", ".mpeg", ".m4v")
ENDINGS = {".png": b"IEND", ".jpg": b"\xff\xd9", ".jpeg": b"\xff\xd9"}  # what a whole file has near its end


def list_images(spec: str) -> list[Path]:
    """Files that the folder, glob, pattern or file name stands for; one video file stands for itself.

    Raises InputError when there are none.
    """
    path = Path(spec)
    if path.is_dir():
        found = [p for p in path.iterdir() if p.suffix.lower() in IMAGES]
    elif path.is_file():
        found = [path]
    elif re.search(r"%0?\d*d", path.name):
        pattern = re.escape(path.name)
        pattern = re.sub(r"%0?\d*d", r"\\d+", pattern)
        folder = path.parent
        found = [p for p in folder.iterdir() if re.fullmatch(pattern, p.name)] if folder.is_dir() else []
    else:
        root = Path(path.anchor) if path.is_absolute() else Path()
        try:
            found = [
                p for p in root.glob(str(path.relative_to(path.anchor) if path.is_absolute() else path)) if p.is_file()
            ]
        except (ValueError, NotImplementedError, OSError):
            found = []
    if not found:
        raise InputError(
            f"images {spec}: found none; give a folder, a quoted pattern ('DIR/*.png', 'DIR/%04d.png') or a video file"
        )
    return sorted(found, key=lambda p: [int(w) if w.isdigit() else w for w in re.split(r"(\d+)", str(p))])


def read_image(path: Path) -> np.ndarray:
    """Image (h, w) grey or (h, w, 3) BGR, uint8. Raises InputError for a missing, truncated or undecodable file."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"image {path}: cannot be read ({error.strerror})") from None
    ending = ENDINGS.get(path.suffix.lower())
    if ending and ending not in data[-4096:]:
        raise InputError(f"image {path}: is truncated or not what its name says ({len(data)} bytes)")
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    except cv2.error:
        image = None
    if image is None or image.size == 0:
        raise InputError(f"image {path}: cannot be decoded ({len(data)} bytes)")
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    if image.dtype != np.uint8:
        raise InputError(f"image {path}: expected 8 or 16 bits a channel, got {image.dtype}")
    if image.ndim == 3 and image.shape[2] == 4:
        image = np.ascontiguousarray(image[..., :3])
    return image[..., 0] if image.ndim == 3 and image.shape[2] == 1 else image


class ImageSequence:
    """The images that ``spec`` stands for, one by one: ``for name, image in sequence`` where image is an InputError if it is bad."""

    def __init__(self, spec: str):
        self.files = list_images(spec)
        self.video = len(self.files) == 1 and self.files[0].suffix.lower() in VIDEOS
        self._spec = spec

    def __len__(self) -> int:
        """Number of images; of a video what its header says, which may be 0."""
        if not self.video:
            return len(self.files)
        import av

        try:
            with av.open(str(self.files[0])) as container:
                return container.streams.video[0].frames
        except (av.error.FFmpegError, IndexError) as error:
            raise InputError(f"video {self._spec}: cannot be opened ({error})") from None

    def __iter__(self) -> Iterator[tuple[str, np.ndarray | InputError]]:
        if self.video:
            yield from self._frames()
            return
        for path in self.files:
            try:
                yield path.name, read_image(path)
            except InputError as error:
                yield path.name, error

    def _frames(self):
        import av

        k = -1
        try:
            with av.open(str(self.files[0])) as container:
                for k, frame in enumerate(container.decode(video=0)):
                    yield f"{self.files[0].name}[{k}]", frame.to_ndarray(format="bgr24")
        except (av.error.FFmpegError, IndexError) as error:
            yield (
                f"{self.files[0].name}[{k + 1}]",
                InputError(f"video {self._spec}: frame {k + 1} cannot be decoded ({error})"),
            )
