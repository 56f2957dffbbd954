# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own arrays, read where they are.

`foreach_get` takes 20 to 100 ns an element where Blender computes or converts it. The addresses of its elements tell
where the array behind a collection is. It is read only where it is laid out as one of the known structs, which is seen
from the addresses and the values of a few elements each time; else `foreach_get` is used. The test test_in_place.py
compares all elements, and shows that nothing else is read.
"""

import ctypes
from typing import NamedTuple

import numpy as np

FEW = 256
"""Below so many elements foreach_get is as fast."""


class Layout(NamedTuple):
    """How a property is kept in memory."""

    kind: type
    components: int
    offsets: dict[int, int]
    """bytes from one element to the next -> bytes from an element's start to the property"""
    mask: int = 0
    """the bits of the number that count; 0: all"""


LAYOUTS = {
    "vertex_index": Layout(np.int32, 1, {8: 0, 4: 0}),  # MLoop; an array of its own since Blender 3.6
    "loops": Layout(np.int32, 3, {16: 0, 12: 0}),  # MLoopTri; its corners alone since 4.0
    "polygon_index": Layout(np.int32, 1, {16: 12}),  # MLoopTri
    "loop_start": Layout(np.int32, 1, {12: 0}),  # MPoly
    "loop_total": Layout(np.int32, 1, {12: 4}),  # MPoly
    "use_smooth": Layout(np.uint8, 1, {12: 10}, mask=1),  # MPoly
    "value": Layout(np.int32, 1, {4: 0}),
    "vector": Layout(np.float32, 3, {12: 0}),
    "uv": Layout(np.float32, 2, {12: 0, 8: 0}),  # MLoopUV; an array of its own since 3.5
}
"""By the property's name in Python. The structs are those of Blender 3.4 to 5.2."""


def view(collection, name: str) -> np.ndarray | None:
    """(N, components) of a property of a collection, or (N,) of one component, in Blender's memory: read only, and only
    as long as the data is as it is. None where it is not laid out as known."""
    layout, count = LAYOUTS.get(name), len(collection)
    if layout is None or count < FEW:
        return None
    looked_at = {i: collection[i] for i in (0, 1, count // 2, count - 1)}
    start = looked_at[0].as_pointer()
    stride = looked_at[1].as_pointer() - start
    offset = layout.offsets.get(stride)
    if offset is None or any(e.as_pointer() != start + i * stride for i, e in looked_at.items()):
        return None
    kind = np.dtype(layout.kind)
    size = (count - 1) * stride + offset + layout.components * kind.itemsize
    memory = (ctypes.c_char * size).from_address(start)
    found = np.ndarray((count, layout.components), kind, memory, offset, (stride, kind.itemsize))
    found.flags.writeable = False
    for i, element in looked_at.items():
        value = np.array(getattr(element, name), dtype=kind).ravel()
        if not np.array_equal(found[i] & layout.mask if layout.mask else found[i], value, equal_nan=kind.kind == "f"):
            return None
    if layout.mask:
        found = found & layout.mask
    return found[:, 0] if layout.components == 1 else found


def column(collection, name: str, kind, components: int = 1) -> np.ndarray:
    """The same, from view() or else a copy; of four bytes an element, and as `kind`."""
    found = view(collection, name)
    if found is None:
        found = np.empty((len(collection), components) if components > 1 else len(collection), dtype=kind)
        collection.foreach_get(name, found.ravel())
    return found.astype(kind, copy=False)
