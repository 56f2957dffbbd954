# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig. 6: the radiance at points of the floor against the number of points on the luminaire.

A picture of one pixel sees the floor point; it is rendered anew with 1, 2, 3 ... points. Repeated with other shapes of
the luminaire and other starting indices (`seed`: Sobol' and Halton begin so many points later, PRS has another seed).
"""

import numpy as np
import references
import scenes
from engine import ExportedScene
from methods import HALTON, OWEN_SOBOL, PRS, SOBOL, Method
from sizes import Size
from tables import Data, Row

SHOWN = [PRS, SOBOL, HALTON, OWEN_SOBOL]
SETTLED_WITHIN = 0.02
"""Of the unshadowed radiance."""
FLOOR_PICTURE = (96, 72)
"""Where floor points are chosen from."""


def measure(data: Data, size: Size) -> None:
    curves, settled = [], []
    for shape in scenes.SHAPES:
        scene = scenes.sphere_on_ground(FLOOR_PICTURE, shape)
        places = floor_points(references.converged(scene, size.reference_points), size.running_places)
        exported, bare = ExportedScene(scene), scenes.unshadowed(scene)
        for part, positions in places.items():
            for number, position in enumerate(positions):
                target = Target(exported, bare, position, size.reference_points)
                for start in size.starts:
                    for method in SHOWN:
                        means = target.running_means(method, start, size.most_running_points)
                        settled.append({"shape": shape, "part": part, "place": number, "start": start,
                                        **method._asdict(), **target.judge(means)})  # fmt: skip
                        if shape == "square" and number == 0 and start == size.starts[0]:
                            curves += [{"part": part, **method._asdict(), "points": n + 1, "value": mean,
                                        "exact": target.exact} for n, mean in enumerate(means)]  # fmt: skip
    data.write("fig6_curves", curves)
    data.write("fig6_settled", settled)


def floor_points(reference: references.Reference, count: int) -> dict[str, np.ndarray]:
    """So many points of the floor in the light and in the penumbra, evenly over the picture."""
    on_floor = np.abs(reference.positions[..., 2]) < 1e-4
    parts = {"lit": on_floor & (reference.classes == references.LIT), "penumbra": reference.half_seen_floor}
    chosen = {}
    for part, mask in parts.items():
        positions = reference.positions[mask]
        chosen[part] = positions[((np.arange(count) + 0.5) * len(positions) / count).astype(int)]
    return chosen


class Target:
    """A floor point, its exact radiance and its unshadowed one, in display units."""

    def __init__(self, exported: ExportedScene, bare: ExportedScene, position, points: int) -> None:
        self._exported = exported
        for scene in (exported, bare):
            scene.look_at_point(position)
        converged = {"light_samples": 4 * points, "seed": references.SEEDS[0], **OWEN_SOBOL.settings}
        self.exact, self.unshadowed = (scene.value_at_point(**converged) for scene in (exported, bare))

    def running_means(self, method: Method, start: int, most: int) -> list[float]:
        return [self._exported.value_at_point(light_samples=n, seed=start, **method.settings)
                for n in range(1, most + 1)]  # fmt: skip

    def judge(self, means: list[float]) -> Row:
        """From how many points on the running mean stays close, and its mean error over the second half of the run."""
        errors = np.abs(np.array(means) - self.exact) / self.unshadowed
        outside = np.nonzero(errors > SETTLED_WITHIN)[0]
        return {"settled_at": int(outside[-1]) + 2 if len(outside) else 1,
                "late_error": float(np.mean(errors[len(errors) // 2 :]))}  # fmt: skip
