# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture that gets better in the background: coarse first, then all pixels, then to the scene's own settings.

Knows nothing of Blender, so that its thread may run whenever it likes. The native renderer's threads do the work; the
one here waits for them and copies their buckets.
"""

from concurrent.futures import ThreadPoolExecutor
from time import perf_counter

import numpy as np

WAIT_SECONDS = 0.02
ESTIMATE_SECONDS = 0.5
"""Between two looks at the estimated error, for which all pixels are read."""
QUICK = {
    "stop_rule": "FIXED", "sampler": "OWEN_SOBOL", "sample_reuse": "SCRAMBLED", "light_samples": 16, "pixel_samples": 1,
}  # fmt: skip
STEPS = 3
FIRST = QUICK | {"light_samples": 4}


def shrunk(size: int, start: int, count: int, divisor: int) -> tuple[int, np.ndarray]:
    """A row of `size` pixels in coarse: (its number of coarse pixels, which of them each pixel of a part shows).

    The part is `count` pixels from `start` on. Both rows span the same length, so the camera's window is the same.
    """
    small = max(size // divisor, 1)
    return small, (2 * np.arange(start, start + count) + 1) * small // (2 * size)


class Refinement:
    """The successively better pictures of one view of one scene.

    scene: a native scene that nothing else changes until run() is over. camera: arguments of its set_camera. settings:
    those of the last, best picture, with width, height and region. divisor: the first picture has so many times fewer
    pixels in each direction. since: the perf_counter() from which on the user waits for it.
    """

    def __init__(self, pn, scene, camera: tuple, settings: dict, divisor: int, since: float) -> None:
        self._pn, self._scene, self._camera, self._settings, self._divisor = pn, scene, camera, settings, divisor
        self._render, self._is_cancelled, self._since = None, False, since
        self.pixels: np.ndarray | None = None
        """(height, width, 4) float32 of the region, bottom row first; None before the first picture"""
        self.seconds_to_first_picture = 0.0
        self.changes = 0
        """counts up with each change of `pixels`, and at the end"""
        self.step, self.progress, self.error_estimate, self.seconds = 0, 0.0, 0.0, 0.0
        """number of the picture in `pixels`, and how far the one is that is being rendered, since so many seconds"""
        self.failure = ""
        self.done = False

    def cancel(self) -> None:
        """Makes run() return soon; does not wait."""
        self._is_cancelled = True
        if self._render is not None:
            self._render.cancel()

    def run(self) -> None:
        """All pictures, one after the other. Never raises: `failure` says what went wrong."""
        try:
            if not self._is_cancelled:
                self._scene.set_camera(*self._camera)
                self._first_picture()
                for step, changed in enumerate((QUICK, {}), 2):
                    self._refine(step, self._settings | changed)
        except Exception as error:
            self.failure = str(error) or type(error).__name__
        finally:
            self._render = self._scene = None
            self.done = True
            self.changes += 1

    def _first_picture(self) -> None:
        """A picture of fewer pixels, stretched."""
        x, y, width, height = self._settings["region"]
        small_width, columns = shrunk(self._settings["width"], x, width, self._divisor)
        small_height, rows = shrunk(self._settings["height"], y, height, self._divisor)
        region = int(columns[0]), int(rows[0]), int(columns[-1] - columns[0]) + 1, int(rows[-1] - rows[0]) + 1
        small = np.zeros((region[3], region[2], 4), dtype=np.float32)
        settings = {"width": small_width, "height": small_height, "region": region}
        for block, pixels in self._buckets(self._settings | FIRST | settings):
            small[block] = pixels
        if not self._is_cancelled:
            self.pixels = small[np.ix_(rows - rows[0], columns - columns[0])]
            self.seconds_to_first_picture = perf_counter() - self._since
            self.step = 1
            self.changes += 1

    def _refine(self, step: int, settings: dict) -> None:
        """Each finished bucket replaces that part of the picture."""
        for block, pixels in self._buckets(settings):
            self.step = step
            self.pixels[block] = pixels
            self.changes += 1

    def _buckets(self, settings: dict):
        """Renders; yields (index of rows and columns, (height, width, 4) float32) of each finished bucket."""
        if self._is_cancelled:
            return
        self._render = render = self._pn.Render(self._scene, settings)
        if self._is_cancelled:  # cancel() may have come before there was this render
            return
        render.start()
        began = told = perf_counter()
        try:
            while not render.done:
                for x, y, width, height in render.wait(WAIT_SECONDS):
                    pixels = render.read("Combined", x, y, width, height).reshape(height, width, 4)
                    yield (slice(y, y + height), slice(x, x + width)), pixels
                self.progress, self.seconds = render.progress, perf_counter() - began
                if perf_counter() - told >= ESTIMATE_SECONDS:
                    told, self.error_estimate = perf_counter(), render.estimated_error
            self.progress, self.error_estimate = render.progress, render.estimated_error
        finally:
            render.cancel()
            render.finish()


class Refiner:
    """Runs refinements, one at a time; a new one cancels the one before. To be closed."""

    def __init__(self) -> None:
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="penumbra")
        self.current: Refinement | None = None

    def start(self, refinement: Refinement) -> None:
        self.cancel()
        self.current = refinement
        self._executor.submit(refinement.run)

    def cancel(self) -> None:
        if self.current is not None:
            self.current.cancel()

    def close(self) -> None:
        """Lets go of everything; what still runs ends after its block."""
        self.cancel()
        self._executor.shutdown(wait=False)
        self.current = None
