"""One picture of the walker: legs, feet at their true geometry, floor, motor.

Points are complex numbers, up + i·forward, in metres along the floor's axes (as in
`physics/swing.py`), so a limb of length a at angle θ ends at a·e^{iθ} from its start.
Down in the picture is the direction of gravity: the floor tilts with the slope.
"""

from __future__ import annotations

import cmath
import itertools
import math
import os
import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from powered_walker_env.pictures.scene import Floor, Scene

Frame = npt.NDArray[np.uint8]  # (height, width, 3), RGB
Colour = tuple[int, int, int]

SKY: Colour = (250, 250, 247)
SOIL: Colour = (222, 219, 211)
LINE: Colour = (62, 60, 56)
MUTED: Colour = (112, 109, 102)
HIP: Colour = (38, 42, 50)
MOTOR: Colour = (255, 149, 0)
ALERT: Colour = (190, 30, 45)
# Two hues that colour-blind eyes tell apart, one for each leg for the whole walk.
LEGS: tuple[Colour, Colour] = ((0, 92, 175), (0, 138, 108))

SUPERSAMPLE = 3  # drawn this much larger, then averaged: pygame's thick lines are not antialiased
NOMINAL_HEIGHT = 360.0  # px, the height for which the line widths below are given
WALKER_SHARE = 0.68  # of the picture's height, the standing walker
SWING_TINT = 0.45  # how far the swing leg fades towards the sky
MARKS_ACROSS = 6  # numbered distance marks in a picture, about
INSET = (104.0, 92.0)  # nominal px, the magnifying glass over a foot too small to see
INSET_FOOT = 38.0  # nominal px, the foot in it


def import_pygame() -> Any:
    """The pygame module.

    Raises:
        ImportError: pygame is not installed; the message says how to install it.
    """
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # pygame 2.6 imports the deprecated pkg_resources
            import pygame
    except ImportError as error:
        raise ImportError(
            "rendering needs pygame, which is not installed; "
            'pip install "powered-walker-env[render]"'
        ) from error
    return pygame


def mixed(colour: Colour, other: Colour, share: float) -> Colour:
    """`share` of the way from one colour to the other."""
    r, g, b = (round(a + share * (z - a)) for a, z in zip(colour, other, strict=True))
    return r, g, b


def mark_spacing(width: float) -> float:
    """A round number, 1, 2 or 5 times a power of ten, near `width` / MARKS_ACROSS."""
    raw = width / MARKS_ACROSS
    power = 10.0 ** math.floor(math.log10(raw))
    return next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= raw * 0.999)


def check_size(name: str, value: object) -> None:
    """Refuse what is not a positive integer.

    Raises:
        ValueError: naming the argument.
    """
    if isinstance(value, bool) or not isinstance(value, int) or value <= 0:
        raise ValueError(f"{name} must be a positive integer (pixels), got {value!r}")


class Painter:
    """Draws scenes on a pygame surface of its own; needs no display.

    Args:
        width, height: of the pictures, px.

    Raises:
        ImportError: pygame is not installed.
        ValueError: a size that is not a positive integer.
    """

    def __init__(self, width: int, height: int) -> None:
        check_size("width", width)
        check_size("height", height)
        self.width, self.height = width, height
        self._pygame = pygame = import_pygame()
        pygame.font.init()
        size = (width * SUPERSAMPLE, height * SUPERSAMPLE)
        self._surface = pygame.Surface(size, 0, 32)
        self._small = pygame.Surface((width, height), 0, 32)
        self._unit = size[1] / NOMINAL_HEIGHT  # drawn px for one px of the nominal picture
        self._fonts = {n: pygame.font.Font(None, max(6, round(n * self._unit))) for n in (18, 22)}
        self._glow = self._make_glow()
        self._scale, self._tilt, self._focus = 1.0, 1.0 + 0.0j, 0.0j
        self._middle = (0.0, 0.0)

    def paint(self, scene: Scene) -> Frame:
        """The picture of a scene."""
        self._aim(scene)
        self._surface.fill(SKY)
        self._paint_floor(scene.floor)
        self._paint_marks(scene.floor)
        self._paint_walker(scene)
        self._paint_labels(scene)
        self._paint_inset(scene)
        self._pygame.transform.smoothscale(self._surface, (self.width, self.height), self._small)
        pixels = np.frombuffer(self._pygame.image.tobytes(self._small, "RGB"), np.uint8)
        return pixels.reshape(self.height, self.width, 3).copy()

    def to_pixels(self, scene: Scene, point: complex) -> tuple[float, float]:
        """Where (column, row) a point of a scene lands in its picture, px."""
        self._aim(scene)
        x, y = self._place(point)
        return x / SUPERSAMPLE, y / SUPERSAMPLE

    def _aim(self, scene: Scene) -> None:
        """Set the map from metres to pixels: scale, tilt, and the middle of the walker."""
        params = scene.params
        tall = params.foot_radius + params.foot_length + params.leg_length
        self._scale = WALKER_SHARE * self._surface.get_height() / tall
        self._tilt = cmath.rect(1.0, params.slope)
        self._focus = scene.focus + 0.5 * tall
        self._middle = (0.5 * self._surface.get_width(), 0.5 * self._surface.get_height())

    def _place(self, point: complex) -> tuple[float, float]:
        offset = (point - self._focus) * self._tilt * self._scale
        return self._middle[0] + offset.imag, self._middle[1] - offset.real

    # Shapes, in drawn pixels ----------------------------------------------------------

    def _line(self, colour: Colour, a: complex, b: complex, width: float) -> None:
        """A straight limb with round ends; `width` in nominal px."""
        self._stroke(colour, [self._place(a), self._place(b)], width)

    def _stroke(self, colour: Colour, points: list[tuple[float, float]], width: float) -> None:
        draw, half = self._pygame.draw, 0.5 * width * self._unit
        for (x0, y0), (x1, y1) in itertools.pairwise(points):
            length = math.hypot(x1 - x0, y1 - y0)
            if length > 0:
                dx, dy = -(y1 - y0) / length * half, (x1 - x0) / length * half
                corners = [(x0 + dx, y0 + dy), (x1 + dx, y1 + dy), (x1 - dx, y1 - dy)]
                draw.polygon(self._surface, colour, [*corners, (x0 - dx, y0 - dy)])
        for point in points:
            draw.circle(self._surface, colour, point, half)

    def _disc(self, colour: Colour, centre: complex, radius: float) -> None:
        """A disc; `radius` in nominal px."""
        self._pygame.draw.circle(self._surface, colour, self._place(centre), radius * self._unit)

    def _make_glow(self) -> Any:
        """The light around a working motor: two flat rings, which a small palette can hold."""
        r = round(19.0 * self._unit)
        glow = self._pygame.Surface((2 * r, 2 * r), self._pygame.SRCALPHA, 32)
        for share, alpha in ((1.0, 60), (0.66, 120)):
            self._pygame.draw.circle(glow, (*MOTOR, alpha), (r, r), share * r)
        return glow

    def _text(
        self, text: str, size: int, colour: Colour, x: float, y: float, align: float = 0.0
    ) -> Any:
        """Text with its top at `y`; `align` is the share of its width left of `x` (drawn px)."""
        image = self._fonts[size].render(text, True, colour)
        return self._surface.blit(image, (x - align * image.get_width(), y))

    # The parts of the picture ---------------------------------------------------------

    def _paint_floor(self, floor: Floor) -> None:
        middle = self._focus.imag
        reach = 1.0 + math.hypot(*self._surface.get_size()) / self._scale
        outline = floor.outline(middle - reach, middle + reach)
        below = [outline[-1] - 2.0 * reach, outline[0] - 2.0 * reach]
        surface = [self._place(point) for point in outline]
        corners = [*surface, *(self._place(point) for point in below)]
        self._pygame.draw.polygon(self._surface, SOIL, corners)
        self._stroke(LINE, surface, 1.8)

    def _paint_marks(self, floor: Floor) -> None:
        """Distance marks under the surface, numbered in metres from the start."""
        middle = self._focus.imag
        width = self._surface.get_width() / self._scale
        spacing = mark_spacing(width)
        first = math.floor((middle - width) / spacing)
        decimals = max(0, -math.floor(math.log10(spacing) + 1e-9))
        for k in range(5 * first, 5 * (first + 2 * MARKS_ACROSS + 2)):
            forward = 0.2 * k * spacing
            top = complex(floor.height(forward), forward)
            numbered = k % 5 == 0
            depth = (9.0 if numbered else 4.0) * self._unit / self._scale
            self._line(MUTED, top, top - depth, 1.4 if numbered else 1.0)
            if numbered:
                x, y = self._place(top - depth)
                text = f"{forward + 0.0:.{decimals}f} m"
                self._text(text, 18, MUTED, x, y + 11.0 * self._unit, 0.5)

    def _paint_walker(self, scene: Scene) -> None:
        pose = scene.pose
        near_is_stance = scene.stride % 2 == 0
        for near in (False, True):
            colour = LEGS[0] if near else LEGS[1]
            if near == near_is_stance:
                self._paint_stance_leg(scene, colour)
            else:
                faded = mixed(colour, SKY, SWING_TINT)
                self._paint_foot(
                    scene, pose.swing_foot, pose.swing_ankle, pose.swing_foot_angle, faded
                )
                self._paint_leg(pose.swing_ankle, pose.hip, faded, 5.0)
        self._disc(HIP, pose.hip, 13.0)
        self._disc(mixed(HIP, SKY, 0.35), pose.hip, 4.5)

    def _paint_stance_leg(self, scene: Scene, colour: Colour) -> None:
        pose = scene.pose
        if scene.motor_on:
            x, y = self._place(pose.ankle)
            half = 0.5 * self._glow.get_width()
            self._surface.blit(self._glow, (x - half, y - half))
        self._paint_foot(scene, pose.foot, pose.ankle, pose.foot_angle, colour)
        self._paint_leg(pose.ankle, pose.hip, colour, 6.4)
        self._disc(LINE, pose.foot - scene.params.foot_radius, 3.0)  # the contact point
        if scene.motor_on:
            self._disc(HIP, pose.ankle, 5.6)
            self._disc(MOTOR, pose.ankle, 4.2)

    def _paint_leg(self, ankle: complex, hip: complex, colour: Colour, width: float) -> None:
        self._line(colour, ankle, hip, width)
        self._disc(colour, ankle, 4.8)
        self._disc(SKY, ankle, 2.1)

    def _paint_foot(
        self, scene: Scene, centre: complex, ankle: complex, angle: float, colour: Colour
    ) -> None:
        """The link from ankle to centre, and the sole: an arc about the centre."""
        low, high = scene.sector
        R = scene.params.foot_radius
        if R * self._scale > 2.0 * self._unit:
            sole = self._arc(centre, R, angle + math.pi - high, angle + math.pi - low)
            fill = mixed(colour, SKY, 0.72)
            self._pygame.draw.polygon(self._surface, fill, [self._place(ankle), *sole])
            edge = mixed(colour, SKY, 0.25)
            self._stroke(edge, [sole[0], self._place(ankle), sole[-1]], 2.0)
            self._stroke(colour, sole, 4.0)
            if not low < angle < high:  # rolled off its sole: the model's foot goes on, round
                end = high if angle > high else low
                self._stroke(edge, self._arc(centre, R, math.pi, angle + math.pi - end), 1.5)
        self._line(colour, ankle, centre, 3.6)
        self._disc(colour, centre, 2.6)

    def _arc(
        self, centre: complex, radius: float, begin: float, end: float
    ) -> list[tuple[float, float]]:
        angles = np.linspace(begin, end, 48).tolist()
        return [self._place(centre + cmath.rect(radius, angle)) for angle in angles]

    def _paint_labels(self, scene: Scene) -> None:
        unit, (width, _) = self._unit, self._surface.get_size()
        left, top = 14.0 * unit, 12.0 * unit
        self._text(f"stride {scene.stride + 1}", 22, HIP, left, top)
        self._text(f"{scene.time:.2f} s", 22, MUTED, left, top + 19.0 * unit)
        slope = math.degrees(scene.params.slope)
        if slope:
            text = f"slope {abs(slope):.2g}° {'down' if slope > 0 else 'up'}"
            self._text(text, 18, MUTED, left, top + 40.0 * unit)
        if scene.verdict:
            self._text(scene.verdict, 22, ALERT, 0.5 * width, top, 0.5)
        self._paint_motor_label(scene.motor_on, width - left, top)

    def _paint_inset(self, scene: Scene) -> None:
        """The stance foot magnified, where it would be too small to see what it does."""
        foot = (scene.params.foot_length + scene.params.foot_radius) * self._scale
        if not 0 < foot < 0.6 * INSET_FOOT * self._unit:
            return
        unit, surface = self._unit, self._surface
        width, height = round(INSET[0] * unit), round(INSET[1] * unit)
        left, top = surface.get_width() - width - round(14.0 * unit), round(42.0 * unit)
        box = self._pygame.Rect(left, top, width, height)
        times = INSET_FOOT * unit / foot
        self._scale, self._focus, self._middle = self._scale * times, scene.pose.foot, box.center
        surface.set_clip(box)
        surface.fill(SKY)
        self._paint_floor(scene.floor)
        self._paint_walker(scene)
        self._text(f"×{times:.2g}", 18, MUTED, box.right - 6 * unit, box.bottom - 16 * unit, 1.0)
        surface.set_clip(None)
        self._pygame.draw.rect(surface, MUTED, box, round(unit), round(2.0 * unit))

    def _paint_motor_label(self, motor_on: bool, right: float, top: float) -> None:
        """The words 'motor on' or 'motor off' in a lozenge, lit or not."""
        unit, draw = self._unit, self._pygame.draw
        size = (88.0 * unit, 23.0 * unit)
        box = self._pygame.Rect(round(right - size[0]), round(top - 4.0 * unit), *map(round, size))
        radius = round(0.5 * size[1])
        draw.rect(self._surface, MOTOR if motor_on else SOIL, box, border_radius=radius)
        text = self._fonts[18].render(
            "motor on" if motor_on else "motor off", True, HIP if motor_on else MUTED
        )
        self._surface.blit(text, text.get_rect(center=box.center))
