"""A surface to draw on in metres: strokes, discs, arcs and words, and the pixels at the end.

Points are complex numbers, up + i·forward, in metres along the floor's axes (as in
`mechanics/chain.py`), so a limb of length a at angle θ ends at a·e^{iθ} from its start.
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

Frame = npt.NDArray[np.uint8]  # (height, width, 3), RGB
Colour = tuple[int, int, int]

SUPERSAMPLE = 3  # drawn this much larger, then averaged: pygame's thick lines are not antialiased
NOMINAL_HEIGHT = 360.0  # px, the height for which line widths and letters are given
LETTERS = (18, 22)  # nominal px, the sizes of words


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


def check_size(name: str, value: object) -> None:
    """Refuse what is not a positive integer.

    Raises:
        ValueError: naming the argument.
    """
    if isinstance(value, bool) or not isinstance(value, int) or value <= 0:
        raise ValueError(f"{name} must be a positive integer (pixels), got {value!r}")


class Canvas:
    """A pygame surface of its own; needs no display, and none that others open or quit.

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
        self.pygame = pygame = import_pygame()
        size = (width * SUPERSAMPLE, height * SUPERSAMPLE)
        self.surface = pygame.Surface(size, 0, 32)
        self._small = pygame.Surface((width, height), 0, 32)
        self.unit = size[1] / NOMINAL_HEIGHT  # drawn px for one px of the nominal picture
        self._fonts: dict[int, Any] = {}
        self.aim(1.0, 0.0, 0.0j)

    def __reduce__(self) -> Any:
        """A copy is a fresh surface of the same size: a picture is drawn anew each time."""
        return type(self), (self.width, self.height)

    def begin(self, colour: Colour) -> None:
        """Fill the surface; fonts anew, for `pygame.quit()`, whoever calls it, breaks old ones."""
        self.pygame.font.init()
        font = self.pygame.font.Font
        self._fonts = {n: font(None, max(6, round(n * self.unit))) for n in LETTERS}
        self.surface.fill(colour)

    def frame(self) -> Frame:
        """What has been drawn."""
        self.pygame.transform.smoothscale(self.surface, (self.width, self.height), self._small)
        pixels = np.frombuffer(self.pygame.image.tobytes(self._small, "RGB"), np.uint8)
        return pixels.reshape(self.height, self.width, 3).copy()

    def aim(self, scale: float, slope: float, focus: complex) -> None:
        """Set the map from metres to pixels: drawn px a metre, tilt, the point in the middle."""
        self.scale, self.tilt, self.focus = scale, cmath.rect(1.0, slope), focus
        self.middle = (0.5 * self.surface.get_width(), 0.5 * self.surface.get_height())

    def place(self, point: complex) -> tuple[float, float]:
        """Where (column, row) a point lands, drawn px."""
        offset = (point - self.focus) * self.tilt * self.scale
        return self.middle[0] + offset.imag, self.middle[1] - offset.real

    # Shapes, in drawn pixels ----------------------------------------------------------

    def line(self, colour: Colour, a: complex, b: complex, width: float) -> None:
        """A straight limb with round ends; `width` in nominal px."""
        self.stroke(colour, [self.place(a), self.place(b)], width)

    def stroke(self, colour: Colour, points: list[tuple[float, float]], width: float) -> None:
        """A line through points with round ends and corners."""
        draw, half = self.pygame.draw, 0.5 * width * self.unit
        for (x0, y0), (x1, y1) in itertools.pairwise(points):
            length = math.hypot(x1 - x0, y1 - y0)
            if length > 0:
                dx, dy = -(y1 - y0) / length * half, (x1 - x0) / length * half
                corners = [(x0 + dx, y0 + dy), (x1 + dx, y1 + dy), (x1 - dx, y1 - dy)]
                draw.polygon(self.surface, colour, [*corners, (x0 - dx, y0 - dy)])
        for point in points:
            draw.circle(self.surface, colour, point, half)

    def disc(self, colour: Colour, centre: complex, radius: float) -> None:
        """A disc; `radius` in nominal px."""
        self.pygame.draw.circle(self.surface, colour, self.place(centre), radius * self.unit)

    def arc(
        self, centre: complex, radius: float, begin: float, end: float
    ) -> list[tuple[float, float]]:
        """Points along a circle, from one angle to another."""
        angles = np.linspace(begin, end, 48).tolist()
        return [self.place(centre + cmath.rect(radius, angle)) for angle in angles]

    def text(
        self, text: str, size: int, colour: Colour, x: float, y: float, align: float = 0.0
    ) -> Any:
        """Text with its top at `y`; `align` is the share of its width left of `x` (drawn px)."""
        image = self._fonts[size].render(text, True, colour)
        return self.surface.blit(image, (x - align * image.get_width(), y))
