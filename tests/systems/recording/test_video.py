"""Videos are read back with PyAV: what was written, what a killed writer leaves, what a full disk says."""

import os
import signal
import subprocess
import sys

import av
import numpy as np
import pytest

from vipr.systems.errors import InputError
from vipr.systems.recording.video import VideoWriter


def ramp(height, width, shift=0):
    """A smooth BGR image that differs from its own shifts and between its channels."""
    x = (np.arange(width) + shift) % width * 255 // width
    y = np.arange(height) * 255 // height
    return np.stack(np.broadcast_arrays(x[None], y[:, None], 128), axis=-1).astype(np.uint8)


def decode(path):
    """Every image that can still be decoded, as BGR."""
    images = []
    with av.open(str(path)) as container:
        try:
            for frame in container.decode(video=0):
                images.append(frame.to_ndarray(format="bgr24"))
        except av.error.InvalidDataError:
            pass  # the last packet was cut
    return images


def test_images_come_back_in_number_size_colour_and_time(tmp_path):
    path = tmp_path / "video.mp4"
    with VideoWriter(path, fps=25) as video:
        for k in range(30):
            video.write(ramp(120, 160, k))
    images = decode(path)
    assert len(images) == video.frames == 30
    assert np.abs(images[7].astype(int) - ramp(120, 160, 7)).mean() < 4
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert float(stream.average_rate) == 25
        assert float(stream.duration * stream.time_base) == pytest.approx(1.2)
    assert list(tmp_path.iterdir()) == [path]


def test_a_closed_video_has_its_index_in_front(tmp_path):
    path = tmp_path / "video.mp4"
    with VideoWriter(path) as video:
        video.write(ramp(32, 32))
    data = path.read_bytes()
    assert 0 < data.index(b"moov") < data.index(b"mdat")
    assert b"moof" not in data


@pytest.mark.parametrize("shape", [(61, 83), (60, 83), (61, 82)])
def test_odd_sizes_are_padded_to_even_ones(tmp_path, shape):
    with VideoWriter(tmp_path / "odd.mp4") as video:
        video.write(ramp(*shape))
    (image,) = decode(tmp_path / "odd.mp4")
    assert image.shape == (shape[0] + shape[0] % 2, shape[1] + shape[1] % 2, 3)


def test_grey_images_stay_grey(tmp_path):
    grey = ramp(64, 64)[..., 1]
    with VideoWriter(tmp_path / "grey.mp4") as video:
        video.write(grey)
    (image,) = decode(tmp_path / "grey.mp4")
    assert np.ptp(image.astype(int), axis=-1).max() <= 2
    assert np.abs(image[..., 1].astype(int) - grey).mean() < 4


def test_no_image_makes_no_file(tmp_path):
    with VideoWriter(tmp_path / "none.mp4"):
        pass
    assert not (tmp_path / "none.mp4").exists()


def test_a_killed_writer_leaves_all_but_the_last_image(tmp_path):
    program = (
        "import os, signal, sys, numpy as np\n"
        "from vipr.systems.recording.video import VideoWriter\n"
        "video = VideoWriter(sys.argv[1])\n"
        "for k in range(40):\n"
        "    video.write(np.full((48, 64, 3), 5 * k, np.uint8))\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", program, str(tmp_path / "cut.mp4")], check=False)
    assert done.returncode == -signal.SIGKILL
    images = decode(tmp_path / "cut.mp4")
    assert len(images) >= 39
    assert np.abs(images[38].astype(int) - 190).max() <= 3


def test_an_exception_still_closes_the_file(tmp_path):
    with pytest.raises(KeyboardInterrupt), VideoWriter(tmp_path / "stopped.mp4") as video:
        video.write(ramp(32, 32))
        raise KeyboardInterrupt
    assert len(decode(tmp_path / "stopped.mp4")) == 1


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_a_full_disk_is_one_line_that_names_the_file(tmp_path):
    path = tmp_path / "full.mp4"
    path.symlink_to("/dev/full")
    with pytest.raises(InputError, match=r"full\.mp4: cannot be written \(No space left"), VideoWriter(path) as video:
        for k in range(5):
            video.write(ramp(48, 64, k))


def test_a_missing_folder_is_one_line_that_names_the_file(tmp_path):
    with pytest.raises(InputError, match=r"absent/v\.mp4: cannot be written \(No such file"):
        VideoWriter(tmp_path / "absent" / "v.mp4").write(ramp(16, 16))


def test_a_change_of_size_is_refused(tmp_path):
    with (
        pytest.raises(InputError, match="image 1 is 32x16 pixels, those before it 16x16"),
        VideoWriter(tmp_path / "v.mp4") as video,
    ):
        video.write(ramp(16, 16))
        video.write(ramp(16, 32))


@pytest.mark.parametrize("image", [np.zeros((4, 4)), np.zeros((0, 4, 3), np.uint8), np.zeros((4, 4, 4), np.uint8)])
def test_what_is_no_image_is_refused(tmp_path, image):
    with pytest.raises(InputError, match="must be"):
        VideoWriter(tmp_path / "v.mp4").write(image)
