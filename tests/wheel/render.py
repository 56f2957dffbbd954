# SPDX-License-Identifier: GPL-3.0-or-later
"""A render with the wheel alone, NumPy in and out: a white floor under a square light, against Lambert's closed form.

Also checked by mypy --strict against the wheel's type stubs.
"""

import numpy as np
import penumbra_native as pn

POWER, SIDE, HEIGHT = 100.0, 1.0, 3.0


def unshadowed(radiance: float) -> float:
    """Radiance of a white Lambertian floor right below the light's centre: form factor of a parallel rectangle.

    Four quarters, each with the corner above the point: 1/(2 pi) (X atan Y' + Y atan X'), X = a/h and so on.
    """
    x = SIDE / 2 / HEIGHT
    root = np.sqrt(1 + x * x)
    return float(radiance * 4 / (2 * np.pi) * 2 * x / root * np.arctan(x / root))


def main() -> None:
    scene = pn.Scene()
    white = scene.add_material("white", diffuse=(1, 1, 1))
    corners = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], dtype=np.float32)
    mesh = scene.add_mesh("floor", corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32))
    scene.add_instance("floor", mesh, np.eye(4), [white])
    radiance = POWER / (np.pi * SIDE**2)
    above = np.eye(4)
    above[2, 3] = HEIGHT
    scene.add_area_light("light", "RECTANGLE", above, (SIDE, SIDE), (radiance,) * 3)
    above[2, 3] = 2
    scene.set_camera("ORTHOGRAPHIC", above, (-0.01, 0.01, -0.01, 0.01), (0.1, 10))

    job = pn.Render(scene, {"width": 9, "height": 9, "passes": ["Combined"]})
    job.start()
    while not job.done:
        job.wait(1.0)
    job.finish()
    picture = job.passes()["Combined"]
    assert picture.shape == (9, 9, 4) and picture.dtype == np.float32
    # 0.1 %: the pixels next to the centre, and no shadow anywhere.
    np.testing.assert_allclose(picture[..., :3], unshadowed(radiance), rtol=1e-3)
    print(f"penumbra_native {pn.__version__} ({pn.isa}, Embree {pn.embree}): as the closed form")


if __name__ == "__main__":
    main()
