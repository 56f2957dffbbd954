# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes against Cycles, pixel by pixel and without noise: an Emission shader shows what a node gives.

Tolerance 2e-4: Cycles' rays go through a filter of 0.01 pixels, not exactly through the centre. Bumps are differences
over a pixel: 3e-3. Normal maps in tangent space: 1e-3, as Cycles leaves interpolated normals unnormalised.
"""

import bpy
import pytest
from material_scenes import Tree, assert_values_equal, show

MIX_MODES = (
    "MIX", "DARKEN", "MULTIPLY", "BURN", "LIGHTEN", "SCREEN", "DODGE", "ADD", "OVERLAY", "SOFT_LIGHT",
    "LINEAR_LIGHT", "DIFFERENCE", "SUBTRACT", "DIVIDE", "HUE", "SATURATION", "COLOR", "VALUE",
)  # fmt: skip
MATHS = (
    "ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "MULTIPLY_ADD", "POWER", "LOGARITHM", "SQRT", "INVERSE_SQRT",
    "ABSOLUTE", "EXPONENT", "MINIMUM", "MAXIMUM", "LESS_THAN", "GREATER_THAN", "SIGN", "COMPARE", "SMOOTH_MIN",
    "SMOOTH_MAX", "ROUND", "FLOOR", "CEIL", "TRUNC", "FRACT", "MODULO", "WRAP", "SNAP", "PINGPONG", "SINE",
    "COSINE", "TANGENT", "ARCSINE", "ARCCOSINE", "ARCTANGENT", "ARCTAN2", "SINH", "COSH", "TANH", "RADIANS",
    "DEGREES",
)  # fmt: skip
VECTOR_MATHS = (
    "ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "MULTIPLY_ADD", "CROSS_PRODUCT", "PROJECT", "REFLECT", "REFRACT",
    "FACEFORWARD", "DOT_PRODUCT", "DISTANCE", "LENGTH", "SCALE", "NORMALIZE", "ABSOLUTE", "MINIMUM", "MAXIMUM",
    "FLOOR", "CEIL", "FRACTION", "MODULO", "WRAP", "SNAP", "SINE", "COSINE", "TANGENT",
)  # fmt: skip


def ramp(t, interpolation):
    node = t.add("ShaderNodeValToRGB", {"Fac": t.noise("Fac")})
    node.color_ramp.elements.new(0.5).color = (1, 0.2, 0.1, 0.5)
    node.color_ramp.interpolation = interpolation
    return node.outputs["Color"]


def curves(t):
    node = t.add("ShaderNodeRGBCurve", {"Color": t.noise()})
    node.mapping.curves[3].points.new(0.5, 0.8)
    node.mapping.curves[0].points.new(0.3, 0.1)
    return node.outputs[0]


def separated_and_combined(t, first, second):
    one = t.add("ShaderNodeSeparateColor", {0: t.noise()}, mode=first)
    return t.add("ShaderNodeCombineColor", dict(enumerate(one.outputs)), mode=second).outputs[0]


def mix(t, mode):
    node = t.add("ShaderNodeMix", data_type="RGBA", blend_type=mode)
    first, second = (s for s in node.inputs if s.type == "RGBA")
    node.inputs[0].default_value = 0.7
    t.tree.links.new(t.noise(scale=2.0), first)
    t.tree.links.new(t.noise(scale=7.0), second)
    return next(s for s in node.outputs if s.type == "RGBA")


def maths(t, operation):
    return t.add(
        "ShaderNodeMath", {0: t.noise("Fac"), 1: t.noise("Fac", scale=5.0), 2: 0.25}, operation=operation
    ).outputs[0]


def vector_maths(t, operation):
    inputs = {0: t.noise(), 1: t.noise(scale=5.0), 2: t.noise(scale=9.0), 3: 0.7}
    node = t.add("ShaderNodeVectorMath", inputs, operation=operation)
    return node.outputs["Value" if operation in ("DOT_PRODUCT", "DISTANCE", "LENGTH") else "Vector"]


def mapping(t, kind):
    inputs = {"Vector": t.coordinates("Generated"), "Rotation": (0.3, 0.5, 0.7), "Scale": (1, 2, 3)}
    if kind in ("POINT", "TEXTURE"):
        inputs["Location"] = (0.1, 0.2, 0.3)
    return t.add("ShaderNodeMapping", inputs, vector_type=kind).outputs[0]


def map_range(t, kind):
    return t.add("ShaderNodeMapRange", {"Value": t.noise("Fac"), 1: 0.3, 2: 0.6}, interpolation_type=kind).outputs[0]


def group(t):
    """sin(x) in a group in a group, the inner one's input through a reroute, the colour made a number on the way."""
    trees = [bpy.data.node_groups.new(name, "ShaderNodeTree") for name in ("Inner", "Outer")]
    for tree in trees:
        if hasattr(tree, "interface"):
            tree.interface.new_socket("X", in_out="INPUT", socket_type="NodeSocketFloat")
            tree.interface.new_socket("Y", in_out="OUTPUT", socket_type="NodeSocketFloat")
        else:
            tree.inputs.new("NodeSocketFloat", "X")
            tree.outputs.new("NodeSocketFloat", "Y")
    inner, outer = trees
    for tree, kind in (inner, "ShaderNodeMath"), (outer, "ShaderNodeGroup"):
        first, last, middle = (tree.nodes.new(k) for k in ("NodeGroupInput", "NodeGroupOutput", kind))
        reroute = tree.nodes.new("NodeReroute")
        if kind == "ShaderNodeMath":
            middle.operation = "SINE"
        else:
            middle.node_tree = inner
        tree.links.new(first.outputs[0], reroute.inputs[0])
        tree.links.new(reroute.outputs[0], middle.inputs[0])
        tree.links.new(middle.outputs[0], last.inputs[0])
    node = t.add("ShaderNodeGroup", node_tree=outer)
    t.tree.links.new(t.noise(), node.inputs[0])
    return node.outputs[0]


def unfed_group(t, kind, name, output):
    """A node in a group in a group whose input `name` comes from the group's, which nothing feeds: as if it were not
    linked."""
    outer, inner = t.add("ShaderNodeGroup"), None
    for depth in range(2):
        tree = bpy.data.node_groups.new(f"{kind} {depth}", "ShaderNodeTree")
        if hasattr(tree, "interface"):
            tree.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketVector")
            tree.interface.new_socket("Y", in_out="OUTPUT", socket_type="NodeSocketColor")
        else:
            tree.inputs.new("NodeSocketVector", name)
            tree.outputs.new("NodeSocketColor", "Y")
        first, last = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        node = tree.nodes.new("ShaderNodeGroup" if inner else kind)
        if inner:
            node.node_tree = inner
        tree.links.new(first.outputs[0], node.inputs[name])
        tree.links.new(node.outputs[0 if inner else output], last.inputs[0])
        inner = tree
    outer.node_tree = inner
    return outer.outputs[0]


def noise(t, dimensions):
    inputs = {"Scale": 3.1, "Detail": 3.5, "Roughness": 0.6, "Distortion": 0.5}
    node = t.add("ShaderNodeTexNoise", noise_dimensions=dimensions)
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    if dimensions in ("1D", "4D"):
        t.tree.links.new(t.coordinates("Object"), node.inputs["W"])
    return node.outputs["Color"]


CASES = {
    **{name: lambda t, name=name: t.coordinates(name)
       for name in ("Generated", "UV", "Object", "Normal", "Reflection")},
    **{name: lambda t, name=name: t.add("ShaderNodeNewGeometry").outputs[name]
       for name in ("Position", "Incoming", "Parametric", "True Normal", "Backfacing")},
    "second UV map": lambda t: t.add("ShaderNodeUVMap", uv_map="Second").outputs[0],
    "vertex colour": lambda t: t.add("ShaderNodeVertexColor", layer_name="Col").outputs["Color"],
    "default vertex colour": lambda t: t.add("ShaderNodeVertexColor").outputs["Color"],
    "vertex alpha": lambda t: t.add("ShaderNodeVertexColor", layer_name="Col").outputs["Alpha"],
    "attribute": lambda t: t.add("ShaderNodeAttribute", attribute_name="height").outputs["Fac"],
    "missing attribute": lambda t: t.add("ShaderNodeAttribute", attribute_name="none").outputs["Color"],
    **{f"noise {n}": lambda t, n=n: noise(t, n) for n in ("1D", "2D", "3D", "4D")},
    "checker": lambda t: t.add("ShaderNodeTexChecker", {"Vector": t.coordinates("UV"), "Scale": 5.0}).outputs["Color"],
    **{f"gradient {k}": lambda t, k=k: t.add("ShaderNodeTexGradient", {"Vector": t.coordinates("Object")},
                                             gradient_type=k).outputs[0]
       for k in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "RADIAL", "SPHERICAL", "QUADRATIC_SPHERE")},
    **{f"ramp {k}": lambda t, k=k: ramp(t, k) for k in ("LINEAR", "CONSTANT", "B_SPLINE")},
    "curves": curves,
    "group": group,
    **{f"{k} {i} of a group that is not fed": lambda t, k=k, i=i, o=o: unfed_group(t, f"ShaderNode{k}", i, o)
       for k, i, o in (("Fresnel", "Normal", "Fac"), ("LayerWeight", "Normal", "Facing"), ("TexNoise", "Vector", "Fac"),
                       ("TexChecker", "Vector", "Color"))},
    **{f"mapping {k}": lambda t, k=k: mapping(t, k) for k in ("POINT", "TEXTURE", "VECTOR", "NORMAL")},
    **{f"map range {k}": lambda t, k=k: map_range(t, k) for k in ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP")},
    "clamp": lambda t: t.add("ShaderNodeClamp", {0: t.noise("Fac"), 1: 0.6, 2: 0.4}, clamp_type="RANGE").outputs[0],
    "hue": lambda t: t.add("ShaderNodeHueSaturation", {"Color": t.noise(), "Hue": 0.7, "Saturation": 1.6, "Value": 0.8,
                                                       "Fac": 0.9}).outputs[0],
    "gamma": lambda t: t.add("ShaderNodeGamma", {"Color": t.noise(), "Gamma": 2.2}).outputs[0],
    "invert": lambda t: t.add("ShaderNodeInvert", {"Color": t.noise(), "Fac": 0.8}).outputs[0],
    "contrast": lambda t: t.add("ShaderNodeBrightContrast", {"Color": t.noise(), 1: 0.1, 2: 0.5}).outputs[0],
    "grey": lambda t: t.add("ShaderNodeRGBToBW", {"Color": t.noise()}).outputs[0],
    **{f"{a} {b}": lambda t, a=a, b=b: separated_and_combined(t, a, b)
       for a, b in (("HSV", "RGB"), ("HSL", "RGB"), ("RGB", "HSV"), ("RGB", "HSL"))},
    "Fresnel": lambda t: t.add("ShaderNodeFresnel", {"IOR": 1.7}).outputs[0],
    **{f"layer weight {k}": lambda t, k=k: t.add("ShaderNodeLayerWeight", {"Blend": 0.3}).outputs[k]
       for k in ("Fresnel", "Facing")},
    "camera ray": lambda t: t.add("ShaderNodeLightPath").outputs["Is Camera Ray"],
    **{f"mix {m}": lambda t, m=m: mix(t, m) for m in MIX_MODES},
    **{f"math {m}": lambda t, m=m: maths(t, m) for m in MATHS},
    **{f"vector {m}": lambda t, m=m: vector_maths(t, m) for m in VECTOR_MATHS},
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_node(scene, name):
    tree = Tree()
    show(scene, tree.emit(CASES[name](tree)))
    # The range of WRAP comes near zero. Cycles 5 rounds noise and bytes' colours otherwise (seen: 2.5e-4).
    tolerance = 2e-3 if name == "vector WRAP" else 2e-4
    assert_values_equal(scene, tolerance * (3 if bpy.app.version >= (5, 0, 0) else 1))


def half(t, vector):
    """A unit vector as a colour, so that no component is lost."""
    inputs = {0: vector, 1: (0.5, 0.5, 0.5), 2: (0.5, 0.5, 0.5)}
    return t.add("ShaderNodeVectorMath", inputs, operation="MULTIPLY_ADD").outputs[0]


@pytest.mark.parametrize("invert", [False, True])
def test_bump(scene, invert):
    tree = Tree()
    bump = tree.bump({"Height": tree.noise("Fac"), "Strength": 0.6, "Distance": 0.2}, invert=invert)
    show(scene, tree.emit(half(tree, bump.outputs[0])))
    assert_values_equal(scene, 3e-3)


@pytest.mark.parametrize("strength", [0.7, 1.6])
@pytest.mark.parametrize(
    ("space", "tolerance"), [("TANGENT", 1e-3), ("OBJECT", 3e-4), ("WORLD", 3e-4), ("BLENDER_OBJECT", 3e-4)]
)
def test_normal_map(scene, space, tolerance, strength):
    tree = Tree()
    node = tree.add("ShaderNodeNormalMap", {"Color": tree.noise(), "Strength": strength}, space=space)
    show(scene, tree.emit(half(tree, node.outputs[0])))
    assert_values_equal(scene, tolerance)
