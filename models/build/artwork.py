"""Prints of the packages: flat colours, lettering and simple pictures, as BGR images of one sheet that goes round the package."""

import cv2
import numpy as np

PIXELS_PER_MM = 3
FONT = cv2.FONT_HERSHEY_DUPLEX


class Sheet:
    """A drawing in millimetres, origin at the left bottom; colours are (r, g, b)."""

    def __init__(self, size, colour):
        self.width, self.height = 1000 * size[0], 1000 * size[1]
        self.image = np.empty((self._px(self.height), self._px(self.width), 3), np.uint8)
        self.image[:] = colour[::-1]

    def _px(self, mm):
        return round(mm * PIXELS_PER_MM)

    def _at(self, x, y):
        return self._px(x), self._px(self.height - y)

    def area(self, x0, y0, x1, y1, colour):
        cv2.rectangle(self.image, self._at(x0, y1), self._at(x1, y0), colour[::-1], cv2.FILLED)

    def shape(self, points, colour):
        p = np.array([self._at(x, y) for x, y in points], np.int32)
        cv2.fillPoly(self.image, [p], colour[::-1], cv2.LINE_AA)

    def disc(self, x, y, rx, ry, colour, angle=0.0):
        cv2.ellipse(
            self.image,
            self._at(x, y),
            (self._px(rx), self._px(ry)),
            angle,
            0,
            360,
            colour[::-1],
            cv2.FILLED,
            cv2.LINE_AA,
        )

    def line(self, points, colour, thickness):
        p = np.array([self._at(x, y) for x, y in points], np.int32)
        cv2.polylines(self.image, [p], False, colour[::-1], max(1, self._px(thickness)), cv2.LINE_AA)

    def text(self, x, y, words, cap_height, colour, weight=0.5):
        """Words centred on x with their foot at y."""
        scale = self._px(cap_height) / 21.0  # this font's capitals are 21 px high at scale 1
        thickness = max(1, self._px(weight))
        (w, _), _ = cv2.getTextSize(words, FONT, scale, thickness)
        px, py = self._at(x, y)
        cv2.putText(self.image, words, (px - w // 2, py), FONT, scale, colour[::-1], thickness, cv2.LINE_AA)

    def small_print(self, x0, y0, x1, y1, colour, pitch=4.0, seed=1):
        """Lines of words too small to read."""
        rng = np.random.default_rng(seed)
        for y in np.arange(y0, y1, pitch):
            x = x0
            while x < x1 - 2:
                length = min(rng.uniform(3, 11), x1 - x)
                self.area(x, y, x + length, y + 0.38 * pitch, colour)
                x += length + 1.6

    def bar_code(self, x, y, width, height, seed=2):
        self.area(x - 2, y - 2, x + width + 2, y + height + 2, (245, 245, 245))
        rng = np.random.default_rng(seed)
        at = x
        while at < x + width:
            bar = rng.choice([0.4, 0.7, 1.1])
            self.area(at, y, min(at + bar, x + width), y + height, (20, 20, 20))
            at += bar + rng.choice([0.5, 0.8, 1.2])


def milk(size):
    """Four columns of 70 mm: front, side, back, side; the roof above the first and third."""
    white, blue, green, dark = (236, 238, 236), (40, 84, 158), (66, 140, 70), (30, 40, 60)
    s = Sheet(size, white)
    for k in range(4):
        x = 70 * k
        s.area(x, 0, x + 70, 42, green)
        s.shape([(x, 42), (x + 20, 52), (x + 45, 44), (x + 70, 42), (x + 70, 38), (x, 38)], green)
        s.area(x, 183, x + 70, 195, blue)
    for x in (0, 140):
        s.text(x + 35, 150, "MILK", 17, blue, 2.2)
        s.text(x + 35, 136, "fresh  3 %", 6, dark, 0.7)
        s.disc(x + 35, 92, 21, 15, (250, 250, 250))
        for px, py, rx, ry in ((26, 96, 7, 5), (43, 86, 8, 5), (40, 100, 4, 3)):
            s.disc(x + px, py, rx, ry, dark, 20)
        s.disc(x + 57, 100, 8, 7, (250, 250, 250))
        s.disc(x + 61, 97, 4, 3, (225, 160, 150))
        s.line([(x + 22, 80), (x + 22, 60)], dark, 2.5)
        s.line([(x + 48, 80), (x + 48, 60)], dark, 2.5)
        s.text(x + 35, 16, "1 litre", 9, white, 1.0)
        s.area(x, 195, x + 70, 250, blue)
        s.text(x + 35, 212, "MILK", 14, white, 1.5)
    for k, x in enumerate((70, 210)):
        s.small_print(x + 9, 90, x + 61, 172, (110, 120, 130), seed=3 + k)
        s.text(x + 35, 62, "pasteurised", 5, dark, 0.6)
    s.bar_code(226, 10, 38, 22)
    return s.image


def rice(size, box):
    """Front 115, side 50, back 115, side 50 mm; the top above the front."""
    x, y, z = (1000 * v for v in box)
    red, cream, gold, dark = (176, 42, 36), (240, 228, 200), (222, 168, 56), (60, 30, 20)
    s = Sheet(size, red)
    for start in (0, x + y):
        c = start + x / 2
        s.area(start, 0, start + x, 18, gold)
        s.disc(c, 118, 50, 30, cream)
        s.text(c, 112, "RICE", 24, red, 3.0)
        s.text(c, 98, "long grain", 7, dark, 0.8)
        s.shape([(c - 34, 52), (c - 26, 34), (c + 26, 34), (c + 34, 52)], (70, 96, 150))
        s.disc(c, 52, 34, 6, (90, 118, 172))
        rng = np.random.default_rng(5)
        for _ in range(150):
            a, r = rng.uniform(0, np.pi), rng.uniform(0, 1) ** 0.5
            s.disc(c + 31 * r * np.cos(a), 52 + 15 * r * np.sin(a), 2.6, 0.9, (248, 244, 230), rng.uniform(0, 180))
        s.text(c, 6, "4 x 100 g", 7, dark, 0.8)
    for k, start in enumerate((x, 2 * x + y)):
        s.area(start + 5, 20, start + y - 5, z - 12, cream)
        s.small_print(start + 9, 60, start + y - 9, z - 20, dark, seed=7 + k)
    s.bar_code(x + 9, 26, 30, 22, seed=9)
    s.area(0, z, x, z + y, red)
    s.text(x / 2, z + 18, "RICE", 16, cream, 2.0)
    return s.image


def book(size, box):
    """Front cover, then the spine."""
    x, y, z = (1000 * v for v in box)
    navy, sand, orange = (32, 48, 84), (232, 214, 176), (214, 112, 48)
    s = Sheet(size, navy)
    s.area(8, 8, x - 8, y - 8, sand)
    s.area(11, 11, x - 11, y - 11, navy)
    s.text(x / 2, 150, "ROBOTS", 15, sand, 1.8)
    s.text(x / 2, 132, "AT HOME", 11, sand, 1.2)
    s.disc(x / 2, 80, 32, 32, orange)
    s.line([(40, 50), (52, 88), (84, 98), (92, 72)], sand, 5)
    for p in ((40, 50), (52, 88), (84, 98)):
        s.disc(*p, 6, 6, sand)
    s.text(x / 2, 22, "a reader", 6, sand, 0.7)
    s.area(x, 0, x + z, y, orange)
    s.area(x + 3, 30, x + z - 3, 150, navy)
    s.area(x + z, 0, x + 2 * z, y, sand)
    return s.image


def can(round_, height):
    """Two fronts, half a turn apart."""
    green, yellow, white = (28, 122, 72), (246, 206, 60), (244, 244, 240)
    s = Sheet((round_, height), green)
    s.area(0, 0, s.width, 7, (150, 152, 155))
    s.area(0, 107, s.width, 115, (150, 152, 155))
    for c in (s.width / 4, 3 * s.width / 4):
        s.disc(c, 66, 36, 24, yellow)
        s.text(c, 60, "LEMON", 13, green, 1.6)
        s.text(c, 30, "soda", 11, white, 1.2)
        s.text(c, 14, "33 cl", 5, white, 0.6)
        for a in np.radians([35, 90, 145]):
            s.disc(c + 30 * np.cos(a), 70 + 26 * np.sin(a), 4, 4, white)
    s.small_print(s.width / 2 - 12, 22, s.width / 2 + 12, 98, white, seed=4)
    s.bar_code(2, 30, 13, 45, seed=6)
    return s.image


def mug(round_, height):
    """Bands and dots on cream."""
    cream, blue, red = (234, 226, 206), (52, 86, 140), (186, 62, 50)
    s = Sheet((round_, height), cream)
    s.area(0, 84, s.width, 90, blue)
    s.area(0, 4, s.width, 12, blue)
    for k in range(8):
        s.disc((k + 0.5) * s.width / 8, 48, 11, 11, red if k % 2 else blue)
        s.disc((k + 0.5) * s.width / 8, 48, 5, 5, cream)
    return s.image


def bottle(round_, height):
    """A label on red plastic, two fronts."""
    red, cream, dark, leaf = (128, 26, 44), (240, 230, 206), (60, 14, 24), (70, 120, 60)
    s = Sheet((round_, height), red)
    s.area(0, 28, s.width, 122, cream)
    s.area(0, 112, s.width, 118, leaf)
    s.area(0, 32, s.width, 36, leaf)
    for c in (s.width / 4, 3 * s.width / 4):
        s.text(c, 90, "BERRY", 12, red, 1.5)
        s.text(c, 76, "syrup", 8, dark, 0.9)
        for dx, dy in ((-9, 56), (0, 50), (9, 57)):
            s.disc(c + dx, dy, 6, 6, red)
            s.disc(c + dx + 2, dy + 2, 1.4, 1.4, cream)
    s.small_print(s.width / 2 - 11, 42, s.width / 2 + 11, 106, dark, seed=8)
    s.bar_code(2, 44, 12, 50, seed=10)
    return s.image
