# SPDX-License-Identifier: GPL-3.0-or-later
"""Any arrays and values into the module: taken, or refused with a message; and what was taken renders finite."""

import numpy as np
import penumbra_native as pn
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule
from scenes import floor, light_above, lit_floor, look_down

REFUSALS = (ValueError, TypeError, MemoryError)
PASSES = ["Combined", "Depth", "Normal", "Position", "Light Samples", "Error Estimate"]

any_dtype = st.one_of(
    hnp.floating_dtypes(), hnp.integer_dtypes(), hnp.unsigned_integer_dtypes(), hnp.boolean_dtypes(),
    hnp.complex_number_dtypes(), hnp.byte_string_dtypes(), hnp.unicode_string_dtypes(), hnp.datetime64_dtypes(),
    st.just(np.dtype(object)),
)  # fmt: skip
any_array = any_dtype.flatmap(
    lambda dtype: (
        hnp.arrays(dtype, hnp.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=4), elements=None)
        if dtype.kind != "O"
        else hnp.arrays(dtype, (2, 3), elements=st.none())
    )
)
numbers = st.one_of(st.floats(-4, 4), st.floats(width=64), st.sampled_from([0.0, 1e-300, 1e300, 1e7, np.nan, np.inf]))
plain = st.floats(-4, 4)
values = st.one_of(
    st.none(), st.booleans(), st.integers(-(2**70), 2**70), numbers, st.text(max_size=5), st.binary(max_size=5)
)
lists = st.lists(values, max_size=3)
names = st.text(st.characters(blacklist_categories=("Cs",), blacklist_characters="\0"), max_size=8)


def vectors(element, n):
    return st.tuples(*[element] * n)


def layouts(array):
    """The same values, laid out otherwise."""
    yield array
    yield np.asfortranarray(array)
    yield np.repeat(array, 2, axis=0)[::2]
    yield array[::-1][::-1]
    yield array.astype(array.dtype.newbyteorder())
    frozen = array.copy()
    frozen.flags.writeable = False
    yield frozen


@given(names, any_array, any_array, st.none() | any_array, st.none() | any_array)
def test_any_arrays_as_a_mesh(name, positions, triangles, normals, slots):
    try:
        assert pn.Scene().add_mesh(name, positions, triangles, normals, slots) == 0
    except REFUSALS as error:
        assert str(error).strip()


@given(hnp.arrays(np.float32, (5, 3), elements=st.floats(-9, 9, width=32)),
       hnp.arrays(np.int32, (4, 3), elements=st.integers(-1, 5)))  # fmt: skip
def test_every_layout_is_taken_or_refused_alike(positions, triangles):
    answers = set()
    for p, t in zip(layouts(positions), layouts(triangles), strict=True):
        try:
            pn.Scene().add_mesh("mesh", p, t)
            answers.add("")
        except ValueError as error:
            answers.add(str(error))
    assert len(answers) == 1


@given(st.sampled_from(["add_material", "add_program", "add_image", "add_instance", "add_area_light", "add_point_light",
                        "add_sun", "add_mesh_light", "set_camera", "set_background", "add_curves", "add_points"]),
       st.lists(values | any_array | vectors(values, 3) | vectors(numbers, 2), max_size=6))  # fmt: skip
def test_any_arguments(method, arguments):
    try:
        getattr(pn.Scene(), method)(*arguments)
    except REFUSALS as error:
        assert str(error).strip()


operations = st.tuples(st.sampled_from([*pn.operations(), "nonsense"]), st.integers(-1, 9),
                       st.lists(st.integers(-1, 9), max_size=9), st.integers(-1, 3),
                       st.sampled_from([0, 0, 0, 1, 12, -1, 2**31 - 1, -(2**31)]))  # fmt: skip
CLOSURES = ["diffuse", "disney", "sheen", "glossy", "correlated glossy", "beckmann", "clearcoat", "phong", "emission",
            "transparent", "holdout", "nonsense"]  # fmt: skip
closures = st.tuples(st.sampled_from(CLOSURES), *[st.integers(-1, 9)] * 4)


@given(hnp.arrays(np.float32, st.tuples(st.integers(0, 9), st.just(3)), elements=st.floats(width=32)),
       st.lists(operations, max_size=6), st.lists(numbers.filter(lambda x: abs(x) < 1e30), max_size=14),
       st.lists(closures, max_size=3), st.integers(-1, 9))  # fmt: skip
def test_any_program(registers, steps, tables, ends, normal):
    """Refused, or it renders."""
    scene = pn.Scene()
    try:
        image = scene.add_image("image", [(1001, "x.exr", pn.encode_image(np.ones((2, 2, 4), np.float32)))])
        paint = scene.add_program("paint", registers, steps, np.array([2, 0, *tables], np.float32), ends, normal)
    except REFUSALS as error:
        assert str(error).strip()
        return
    assert image == 0
    scene.add_instance("floor", scene.add_mesh("floor", *floor()), np.eye(4), [paint])
    scene.add_point_light("bulb", light_above(), 0.1, (1, 1, 1))
    look_down(scene)
    for rule_name in ("FIXED", "BOUNDED"):
        finite(scene, {"width": 4, "height": 4, "stop_rule": rule_name, "light_samples": 4, "max_light_samples": 32})


def finite(scene, chosen):
    """Renders; every value of every pass is finite, alpha in 0 ... 1."""
    job = pn.Render(scene, {"passes": PASSES, "threads": 2, **chosen})
    job.start()
    job.finish()
    for name, pixels in job.passes().items():
        assert np.isfinite(pixels).all(), name
    alpha = job.passes()["Combined"][..., 3]
    assert alpha.min() >= 0 and alpha.max() <= 1


SETTINGS = [
    "region", "stop_rule", "sampler", "sample_reuse", "light_samples", "max_light_samples", "check_interval",
    "pixel_samples", "max_pixel_samples", "filter_type", "filter_width", "mirror_depth", "seed", "error_tolerance",
    "exposure", "threads", "passes", "memory_limit", "nonsense",
]  # fmt: skip


@given(st.dictionaries(st.sampled_from(SETTINGS), values | vectors(st.integers(-1, 9), 4) | lists),
       values | st.integers(1, 64), values | st.integers(1, 64))  # fmt: skip
def test_any_settings(given_settings, width, height):
    """Made, not started: a million samples are legal, and long."""
    if isinstance(width, int) and isinstance(height, int) and 2**22 < width * height <= 2**30:
        return  # legal, and gigabytes
    try:
        pn.Render(lit_floor(), {"width": width, "height": height, **given_settings})
    except REFUSALS as error:
        assert str(error).strip()


class Scenes(RuleBasedStateMachine):
    """Scenes grow by any calls in any order; each that can be rendered is, and is finite."""

    @initialize()
    def start(self):
        self.scene = pn.Scene()
        self.scene.add_material("grey", (0.5,) * 3)
        self.attempt(self.scene.add_mesh, "floor", *floor())
        look_down(self.scene)

    def attempt(self, function, *arguments, **named):
        try:
            return function(*arguments, **named)
        except ValueError as error:
            assert str(error).strip()

    @rule(
        positions=hnp.arrays(float, (6, 3), elements=numbers),
        triangles=hnp.arrays(np.int32, (5, 3), elements=st.integers(0, 6)),
    )
    def mesh(self, positions, triangles):
        self.attempt(self.scene.add_mesh, "mesh", positions, triangles)

    @rule(
        keys=hnp.arrays(float, (8, 3), elements=numbers),
        radii=hnp.arrays(float, 8, elements=numbers),
        counts=st.lists(st.integers(0, 8), max_size=4) | st.just([3, 5]),
        shape=st.sampled_from(["RIBBON", "TUBE"]),
        moved=st.none() | hnp.arrays(float, (8, 3), elements=numbers),
    )
    def strands(self, keys, radii, counts, shape, moved):
        motion = [] if moved is None else [keys, moved]
        counted = np.array(counts, np.int32)
        self.attempt(self.scene.add_curves, "hair", keys, radii, counted, shape, motion=motion)
        self.attempt(self.scene.add_points, "drops", keys, radii, motion=motion)

    @rule(mesh=st.integers(0, 3), place=vectors(numbers, 3), scale=vectors(numbers, 3),
          moved=st.none() | vectors(numbers, 3))  # fmt: skip
    def instance(self, mesh, place, scale, moved):
        matrix = np.diag([*scale, 1.0])
        matrix[:3, 3] = place
        end = matrix.copy()
        end[:3, 3] = moved or place
        self.attempt(self.scene.add_instance, "instance", mesh, matrix, [0], motion=[matrix, end] if moved else [])

    @rule(matrix=hnp.arrays(float, (3, 4), elements=plain), size=vectors(numbers, 2), radiance=vectors(numbers, 3),
          shape=st.sampled_from(["RECTANGLE", "ELLIPSE"]), shadow=st.booleans())  # fmt: skip
    def light(self, matrix, size, radiance, shape, shadow):
        placed = np.vstack([matrix, [0, 0, 0, 1]])
        self.attempt(self.scene.add_area_light, "light", shape, placed, size, radiance, shadow)

    @rule(matrix=hnp.arrays(float, (3, 4), elements=plain), radius=numbers, intensity=vectors(numbers, 3),
          spot=st.none() | vectors(numbers, 2), shape=st.sampled_from(["SPHERE", "FACING_DISK"]))  # fmt: skip
    def point(self, matrix, radius, intensity, spot, shape):
        placed = np.vstack([matrix, [0, 0, 0, 1]])
        self.attempt(self.scene.add_point_light, "bulb", placed, radius, intensity, shape=shape, spot=spot)

    @rule(to_sun=vectors(numbers, 3), angle=numbers, irradiance=vectors(numbers, 3))
    def sun(self, to_sun, angle, irradiance):
        self.attempt(self.scene.add_sun, "sun", to_sun, angle, irradiance)

    @rule(
        positions=hnp.arrays(float, (6, 3), elements=numbers),
        triangles=hnp.arrays(np.int32, (5, 3), elements=st.integers(0, 6)),
        radiance=vectors(numbers, 3),
    )
    def glowing(self, positions, triangles, radiance):
        self.attempt(self.scene.add_mesh_light, "glowing", positions, triangles, np.eye(4), radiance)

    @rule(color=vectors(numbers, 3), lights=st.booleans(), smooth=st.booleans(),
          image=st.none() | hnp.arrays(np.float32, (2, 4, 3), elements=st.floats(width=32)))  # fmt: skip
    def sky(self, color, lights, smooth, image):
        self.attempt(self.scene.set_background, color, lights=lights, image=image, smooth=smooth)

    @rule()
    def plain_light(self):
        self.attempt(self.scene.add_area_light, "key", "RECTANGLE", light_above(), (1, 1), (3, 3, 3))

    @rule(rule_name=st.sampled_from(["BOUNDED", "FIXED", "PAPER", "VARIANCE"]), pixel_samples=st.integers(1, 3),
          region=st.none() | vectors(st.integers(0, 9), 4))  # fmt: skip
    def render(self, rule_name, pixel_samples, region):
        samples = {"light_samples": 8, "max_light_samples": 32, "pixel_samples": pixel_samples, "max_pixel_samples": 32}
        chosen = {"width": 9, "height": 7, "stop_rule": rule_name, **samples}
        self.attempt(finite, self.scene, chosen | ({"region": region} if region else {}))


TestScenes = Scenes.TestCase
TestScenes.settings = settings(max_examples=max(50, settings.default.max_examples // 4), stateful_step_count=30)
