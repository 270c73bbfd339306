"""One picture of the walker: legs, feet at their true geometry, floor, motor.

Points are complex numbers, as `canvas` has them.
"""

from __future__ import annotations

import math
from typing import Any

from powered_walker_env.pictures.canvas import SUPERSAMPLE, Canvas, Colour, Frame
from powered_walker_env.pictures.scene import Floor, Scene

SKY: Colour = (250, 250, 247)
SOIL: Colour = (222, 219, 211)
LINE: Colour = (62, 60, 56)
MUTED: Colour = (112, 109, 102)
HIP: Colour = (38, 42, 50)
MOTOR: Colour = (255, 149, 0)
ALERT: Colour = (190, 30, 45)
# Two hues that colour-blind eyes tell apart, one for each leg for the whole walk.
LEGS: tuple[Colour, Colour] = ((0, 92, 175), (0, 138, 108))

WALKER_SHARE = 0.68  # of the picture's height, the standing walker
SWING_TINT = 0.45  # how far the swing leg fades towards the sky
MARKS_ACROSS = 6  # numbered distance marks in a picture, about
INSET = (104.0, 92.0)  # nominal px, the magnifying glass over a foot too small to see
INSET_FOOT = 38.0  # nominal px, the foot in it


def mixed(colour: Colour, other: Colour, share: float) -> Colour:
    """`share` of the way from one colour to the other."""
    r, g, b = (round(a + share * (z - a)) for a, z in zip(colour, other, strict=True))
    return r, g, b


def mark_spacing(width: float) -> float:
    """A round number, 1, 2 or 5 times a power of ten, near `width` / MARKS_ACROSS."""
    raw = width / MARKS_ACROSS
    power = 10.0 ** math.floor(math.log10(raw))
    return next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= raw * 0.999)


class Painter(Canvas):
    """A canvas that knows what a walker looks like; size and errors as there."""

    def __init__(self, width: int, height: int) -> None:
        super().__init__(width, height)
        self._glow = self._make_glow()

    def paint(self, scene: Scene) -> Frame:
        """The picture of a scene."""
        self._aim_at(scene)
        self.begin(SKY)
        self._paint_floor(scene.floor)
        self._paint_marks(scene.floor)
        self._paint_walker(scene)
        self._paint_labels(scene)
        self._paint_inset(scene)
        return self.frame()

    def to_pixels(self, scene: Scene, point: complex) -> tuple[float, float]:
        """Where (column, row) a point of a scene lands in its picture, px."""
        self._aim_at(scene)
        x, y = self.place(point)
        return x / SUPERSAMPLE, y / SUPERSAMPLE

    def _aim_at(self, scene: Scene) -> None:
        """The middle of the walker in the middle of the picture."""
        params = scene.params
        tall = params.foot_radius + params.foot_length + params.leg_length
        scale = WALKER_SHARE * self.surface.get_height() / tall
        self.aim(scale, params.slope, scene.focus + 0.5 * tall)

    def _make_glow(self) -> Any:
        """The light around a working motor: two flat rings, which a small palette can hold."""
        r = round(19.0 * self.unit)
        glow = self.pygame.Surface((2 * r, 2 * r), self.pygame.SRCALPHA, 32)
        for share, alpha in ((1.0, 60), (0.66, 120)):
            self.pygame.draw.circle(glow, (*MOTOR, alpha), (r, r), share * r)
        return glow

    # The parts of the picture ---------------------------------------------------------

    def _paint_floor(self, floor: Floor) -> None:
        middle = self.focus.imag
        reach = 1.0 + math.hypot(*self.surface.get_size()) / self.scale
        outline = floor.outline(middle - reach, middle + reach)
        below = [outline[-1] - 2.0 * reach, outline[0] - 2.0 * reach]
        surface = [self.place(point) for point in outline]
        corners = [*surface, *(self.place(point) for point in below)]
        self.pygame.draw.polygon(self.surface, SOIL, corners)
        self.stroke(LINE, surface, 1.8)

    def _paint_marks(self, floor: Floor) -> None:
        """Distance marks under the surface, numbered in metres from the start."""
        middle = self.focus.imag
        width = self.surface.get_width() / self.scale
        spacing = mark_spacing(width)
        first = math.floor((middle - width) / spacing)
        decimals = max(0, -math.floor(math.log10(spacing) + 1e-9))
        for k in range(5 * first, 5 * (first + 2 * MARKS_ACROSS + 2)):
            forward = 0.2 * k * spacing
            top = complex(floor.height(forward), forward)
            numbered = k % 5 == 0
            depth = (9.0 if numbered else 4.0) * self.unit / self.scale
            self.line(MUTED, top, top - depth, 1.4 if numbered else 1.0)
            if numbered:
                x, y = self.place(top - depth)
                text = f"{forward + 0.0:.{decimals}f} m"
                self.text(text, 18, MUTED, x, y + 11.0 * self.unit, 0.5)

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
                self._paint_leg(pose.swing_ankle, pose.swing_knee, pose.hip, faded, 5.0)
        self.disc(HIP, pose.hip, 13.0)
        self.disc(mixed(HIP, SKY, 0.35), pose.hip, 4.5)

    def _paint_stance_leg(self, scene: Scene, colour: Colour) -> None:
        pose = scene.pose
        if scene.motor_on:
            x, y = self.place(pose.ankle)
            half = 0.5 * self._glow.get_width()
            self.surface.blit(self._glow, (x - half, y - half))
        self._paint_foot(scene, pose.foot, pose.ankle, pose.foot_angle, colour)
        self._paint_leg(pose.ankle, pose.knee, pose.hip, colour, 6.4)
        self.disc(LINE, pose.foot - scene.params.foot_radius, 3.0)  # the contact point
        if scene.motor_on:
            self.disc(HIP, pose.ankle, 5.6)
            self.disc(MOTOR, pose.ankle, 4.2)

    def _paint_leg(
        self, ankle: complex, knee: complex, hip: complex, colour: Colour, width: float
    ) -> None:
        self.line(colour, knee, hip, width)
        if knee != ankle:
            self.line(colour, ankle, knee, width)
            self.disc(colour, knee, 0.9 * width)
            self.disc(SKY, knee, 0.35 * width)
        self.disc(colour, ankle, 4.8)
        self.disc(SKY, ankle, 2.1)

    def _paint_foot(
        self, scene: Scene, centre: complex, ankle: complex, angle: float, colour: Colour
    ) -> None:
        """The link from ankle to centre, and the sole: an arc about the centre."""
        low, high = scene.sector
        R = scene.params.foot_radius
        if R * self.scale > 2.0 * self.unit:
            sole = self.arc(centre, R, angle + math.pi - high, angle + math.pi - low)
            fill = mixed(colour, SKY, 0.72)
            self.pygame.draw.polygon(self.surface, fill, [self.place(ankle), *sole])
            edge = mixed(colour, SKY, 0.25)
            self.stroke(edge, [sole[0], self.place(ankle), sole[-1]], 2.0)
            self.stroke(colour, sole, 4.0)
            if not low < angle < high:  # rolled off its sole: the model's foot goes on, round
                end = high if angle > high else low
                self.stroke(edge, self.arc(centre, R, math.pi, angle + math.pi - end), 1.5)
        self.line(colour, ankle, centre, 3.6)
        self.disc(colour, centre, 2.6)

    def _paint_labels(self, scene: Scene) -> None:
        unit, (width, _) = self.unit, self.surface.get_size()
        left, top = 14.0 * unit, 12.0 * unit
        self.text(f"stride {scene.stride + 1}", 22, HIP, left, top)
        self.text(f"{scene.time:.2f} s", 22, MUTED, left, top + 19.0 * unit)
        slope, below = math.degrees(scene.params.slope), top + 40.0 * unit
        if scene.name:
            self.text(scene.name, 22, LEGS[0], left, below)
            below += 20.0 * unit
        if slope:
            text = f"slope {abs(slope):.2g}° {'down' if slope > 0 else 'up'}"
            self.text(text, 18, MUTED, left, below)
        if scene.verdict:
            self.text(scene.verdict, 22, ALERT, 0.5 * width, top, 0.5)
        if scene.motor_on is not None:
            self._paint_motor_label(scene.motor_on, width - left, top)

    def _paint_inset(self, scene: Scene) -> None:
        """The stance foot magnified, where it would be too small to see what it does."""
        foot = (scene.params.foot_length + scene.params.foot_radius) * self.scale
        if not 0 < foot < 0.6 * INSET_FOOT * self.unit:
            return
        unit, surface = self.unit, self.surface
        width, height = round(INSET[0] * unit), round(INSET[1] * unit)
        left, top = surface.get_width() - width - round(14.0 * unit), round(42.0 * unit)
        box = self.pygame.Rect(left, top, width, height)
        times = INSET_FOOT * unit / foot
        self.scale, self.focus, self.middle = self.scale * times, scene.pose.foot, box.center
        surface.set_clip(box)
        surface.fill(SKY)
        self._paint_floor(scene.floor)
        self._paint_walker(scene)
        self.text(f"×{times:.2g}", 18, MUTED, box.right - 6 * unit, box.bottom - 16 * unit, 1.0)
        surface.set_clip(None)
        self.pygame.draw.rect(surface, MUTED, box, round(unit), round(2.0 * unit))

    def _paint_motor_label(self, motor_on: bool, right: float, top: float) -> None:
        """The words 'motor on' or 'motor off' in a lozenge, lit or not."""
        unit, draw = self.unit, self.pygame.draw
        size = (88.0 * unit, 23.0 * unit)
        box = self.pygame.Rect(round(right - size[0]), round(top - 4.0 * unit), *map(round, size))
        radius = round(0.5 * size[1])
        draw.rect(self.surface, MOTOR if motor_on else SOIL, box, border_radius=radius)
        text = self._fonts[18].render(
            "motor on" if motor_on else "motor off", True, HIP if motor_on else MUTED
        )
        self.surface.blit(text, text.get_rect(center=box.center))
