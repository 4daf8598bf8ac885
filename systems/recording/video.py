"""H.264 video that can be watched whatever ends the program that writes it.

While it is written the file is a fragmented MP4 with one fragment a frame and no encoder delay: cut anywhere, it plays up to the last
whole frame. Closing it rewrites the container (no frame is encoded again) as an ordinary MP4 with its index in front, which
every player can seek in.
"""

import os
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

from vipr.systems.errors import InputError


class VideoWriter:
    """Writes images to an MP4 file at a constant rate: ``with VideoWriter(path, fps=25) as video: video.write(image)``.

    The first image sets the size; an odd width or height is padded by one repeated column or row, because yuv420p halves both. Without any
    image no file is made. A file that cannot be written is an `InputError` that names it.

    Args:
        path: the file to write; an existing one is overwritten.
        fps: images a second of video, positive.
        crf: x264's constant quality, 0 (lossless) to 51 (worst).
        preset: x264's trade of time for size.
    """

    def __init__(self, path: str | Path, fps: float = 25.0, *, crf: int = 23, preset: str = "veryfast"):
        if not fps > 0:
            raise InputError(f"video {path}: the rate must be positive, got {fps} images/s")
        self.path = Path(path)
        self.frames = 0  # written so far
        self._rate = Fraction(fps).limit_denominator(1001)
        self._options = {"crf": str(crf), "preset": preset, "tune": "zerolatency"}
        self._container = None
        self._stream = None
        self._shape = None  # of the images, (h, w)

    def write(self, image: np.ndarray) -> None:
        """Append an image, (h, w, 3) BGR or (h, w) grey, uint8, of the first one's height and width."""
        if image.dtype != np.uint8 or image.size == 0 or image.shape[2:] not in ((), (3,)):
            raise InputError(
                f"video {self.path}: images must be (h, w, 3) or (h, w) of uint8, got {image.shape} of {image.dtype}"
            )
        if self._shape is None:
            self._shape = image.shape[:2]
        elif image.shape[:2] != self._shape:
            (h, w), (height, width) = image.shape[:2], self._shape
            raise InputError(
                f"video {self.path}: image {self.frames} is {w}x{h} pixels, those before it {width}x{height}"
            )
        try:
            if self._container is None:
                self._open()
            frame = av.VideoFrame.from_ndarray(_yuv(image), format="yuv420p")
            frame.pts = self.frames
            self._container.mux(self._stream.encode(frame))
        except OSError as error:
            self._abandon()
            raise _cannot_be_written(self.path, error) from None
        self.frames += 1

    def close(self) -> None:
        """Finish the file. Further calls do nothing."""
        if self._container is None:
            return
        try:
            self._container.mux(self._stream.encode(None))
            self._container.close()
        except OSError as error:
            raise _cannot_be_written(self.path, error) from None
        finally:
            self._container = self._stream = None
        _index(self.path)

    def __enter__(self) -> "VideoWriter":
        return self

    def __exit__(self, *exception) -> None:
        self.close()

    def _open(self) -> None:
        self._container = av.open(
            str(self.path),
            "w",
            format="mp4",
            options={"movflags": "frag_every_frame+empty_moov+default_base_moof", "flush_packets": "1"},
        )
        self._stream = self._container.add_stream("libx264", rate=self._rate)
        height, width = self._shape
        self._stream.width, self._stream.height = width + width % 2, height + height % 2
        self._stream.pix_fmt = "yuv420p"
        self._stream.options = self._options
        codec = self._stream.codec_context
        codec.gop_size = max(1, round(self._rate))  # a key frame a second
        codec.time_base = 1 / self._rate
        codec.color_range, codec.colorspace = 1, 6  # 16 to 235 and BT.601, which OpenCV converts to

    def _abandon(self) -> None:
        """Let go of a container that cannot be written to; its own last words do not matter any more."""
        container, self._container, self._stream = self._container, None, None
        try:
            if container is not None:
                container.close()
        except OSError:
            pass


def _yuv(image: np.ndarray) -> np.ndarray:
    """Planar YUV 4:2:0, (3/2 h, w), of an image padded to an even height and width."""
    h, w = image.shape[:2]
    if h % 2 or w % 2:
        image = cv2.copyMakeBorder(image, 0, h % 2, 0, w % 2, cv2.BORDER_REPLICATE)
    if image.ndim == 2:
        image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    return cv2.cvtColor(image, cv2.COLOR_BGR2YUV_I420)


def _index(path: Path) -> None:
    """Rewrite a fragmented MP4 as one with an index in front. If that fails the fragmented one stays, which plays as well."""
    indexed = path.with_name(f".{path.name}.indexed")
    try:
        with (
            av.open(str(path)) as source,
            av.open(str(indexed), "w", format="mp4", options={"movflags": "faststart"}) as target,
        ):
            stream = target.add_stream_from_template(source.streams.video[0])
            for packet in source.demux(video=0):
                if packet.dts is not None:
                    packet.stream = stream
                    target.mux(packet)
        os.replace(indexed, path)
    except OSError:
        indexed.unlink(missing_ok=True)


def _cannot_be_written(path: Path, error: OSError) -> InputError:
    return InputError(f"video {path}: cannot be written ({os.strerror(error.errno) if error.errno else error})")
