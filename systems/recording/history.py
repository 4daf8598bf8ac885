"""What the report needs of a run, kept in memory as it goes: numbers by tick, events, a few stills."""

import cv2
import numpy as np

from vipr.systems.recording.channels import (
    Channel,
    Event,
    ImageChannel,
    JointChannel,
    PoseChannel,
    StatusChannel,
    VectorChannel,
)
from vipr.systems.recording.log import known

STILLS = 6  # in a report
NO_POSE = np.full((4, 4), np.nan)


class History:
    """Grows by one row a tick: 8 bytes a number, 128 a pose, and never more than two dozen stills."""

    def __init__(self, channels: tuple[Channel, ...]):
        self._channels = {channel.name: channel for channel in channels}
        self._times: list[float] = []
        self._rows: dict[str, list[np.ndarray]] = {
            c.name: [] for c in channels if isinstance(c, PoseChannel | VectorChannel | JointChannel)
        }
        # Last status of each source: a track starts lost, and that is no event.
        self._said = {c.name: "lost" for c in channels if isinstance(c, PoseChannel) and c.tracked}
        self._stills: list[tuple[float, np.ndarray]] = []
        self._stride = 1  # every so many-th image is kept
        self._images = 0
        self._last_image: tuple[float, np.ndarray] | None = None
        self.events: list[Event] = []

    def add(self, time: float, values: dict) -> list[Event]:
        """Keep a tick, and return the events that its values tell of."""
        self._times.append(time)
        events = []
        for name, channel in self._channels.items():
            value = values.get(name)
            if value is None:  # nobody wired it
                if name in self._rows:
                    self._rows[name].append(
                        NO_POSE if isinstance(channel, PoseChannel) else np.full(channel.size, np.nan)
                    )
            elif isinstance(channel, PoseChannel):
                X = value.X_CO if channel.tracked else value
                self._rows[name].append(X if known(channel, value) else NO_POSE)
                if channel.tracked:
                    level = "info" if value.state == "tracking" else "warning"
                    events += self._change(time, name, value.state, level)
            elif isinstance(channel, StatusChannel):
                events += self._change(time, name, value.text, value.level)
            elif isinstance(channel, ImageChannel):
                if channel.video and value.arrived:
                    self._keep(time, value.image)
            else:
                self._rows[name].append(value)
        self.events += events
        return events

    @property
    def times(self) -> np.ndarray:
        """Simulated time of each tick [s], (n,)."""
        return np.array(self._times)

    @property
    def duration(self) -> float:
        """Simulated time of the last tick or event [s]; 0 before the first."""
        return max([0.0, *self._times[-1:], *(event.time for event in self.events[-1:])])

    def poses(self, name: str) -> np.ndarray:
        """(n, 4, 4) poses of a pose channel, NaN where there was none."""
        return np.array(self._rows[name]).reshape(-1, 4, 4)

    def numbers(self, name: str) -> np.ndarray:
        """(n,) numbers of ``channel.name``: a number of a vector channel, or a joint's position."""
        channel_name, _, number = name.partition(".")
        channel = self._channels[channel_name]
        column = (channel.joints if isinstance(channel, JointChannel) else channel.names).index(number)
        return np.array([row[column] for row in self._rows[channel_name]], float)

    def error_norms(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Distance [mm] and angle [deg] (n,) of a vector channel rx, ry, rz, x, y, z [rad, m] that holds a pose's error."""
        rotation, translation = (
            np.stack([self.numbers(f"{name}.{axis}") for axis in axes], axis=1) for axes in (("rx", "ry", "rz"), "xyz")
        )
        return 1e3 * np.linalg.norm(translation, axis=1), np.rad2deg(np.linalg.norm(rotation, axis=1))

    def stills(self) -> list[tuple[float, bytes]]:
        """Up to six stills over the whole run, the first and the last image among them: (time [s], JPEG)."""
        kept = self._stills
        if self._last_image is not None and kept[-1][0] != self._last_image[0]:
            kept = [*kept, self._last_image]
        times = np.array([time for time, _ in kept])
        wanted = np.linspace(times[0], times[-1], STILLS) if kept else []
        chosen = sorted({int(np.argmin(np.abs(times - time))) for time in wanted})
        return [(kept[i][0], _jpeg(kept[i][1])) for i in chosen]

    def _change(self, time: float, source: str, text: str, level: str) -> list[Event]:
        if self._said.get(source, "") == text:
            return []
        self._said[source] = text
        return [Event(time, source, text, level)]

    def _keep(self, time: float, image: np.ndarray) -> None:
        if self._images % self._stride == 0:
            self._stills.append((time, image))
            if len(self._stills) == 4 * STILLS:
                self._stills, self._stride = self._stills[::2], 2 * self._stride
        self._images += 1
        self._last_image = (time, image)


def _jpeg(image: np.ndarray, width: int = 480) -> bytes:
    if image.shape[1] > width:
        image = cv2.resize(image, (width, round(image.shape[0] * width / image.shape[1])), interpolation=cv2.INTER_AREA)
    return cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()
