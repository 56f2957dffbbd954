# SPDX-License-Identifier: GPL-3.0-or-later
"""What pictures are compared with: closed forms and brute force in float64, written without the engine.

A form factor F is for a surface element: E = pi L_e F, and a Lambertian surface of albedo rho sends back rho L_e F.
"""

import numpy as np


def rectangle_corners(matrix, size):
    """Corners (4, 3) in the world of a luminaire in its local xy plane."""
    local = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * [size[0] / 2, size[1] / 2, 0]
    return local @ matrix[:3, :3].T + matrix[:3, 3]


def ellipse_corners(matrix, size, count=8192):
    """Inscribed polygon; its area falls short by (2 pi / count)^2 / 6, 1e-7 for 8192 corners."""
    a = 2 * np.pi * np.arange(count) / count
    local = np.stack([np.cos(a) * size[0] / 2, np.sin(a) * size[1] / 2, 0 * a], axis=1)
    return local @ matrix[:3, :3].T + matrix[:3, 3]


def clip(polygon, point, normal):
    """The part of a polygon on the normal's side of a plane through the point (Sutherland and Hodgman 1974)."""
    out = []
    heights = (polygon - point) @ normal
    for a, b, ha, hb in zip(polygon, np.roll(polygon, -1, 0), heights, np.roll(heights, -1), strict=True):
        if ha >= 0:
            out.append(a)
        if (ha > 0 > hb) or (ha < 0 < hb):
            out.append(a + (b - a) * (ha / (ha - hb)))
    return np.array(out).reshape(-1, 3)


def lambert(polygon, point, normal):
    """Form factor of a flat polygon that emits to both sides, from one surface element: Lambert 1760.

    F = |sum of Gamma_i n . c_i / |c_i|| / (2 pi), c_i = a_i x edge_i, Gamma_i = atan2(|c_i|, a_i . a_(i+1)); the
    edge form keeps digits where the polygon is small or far. The polygon is clipped to the element's horizon first.
    """
    p = clip(np.asarray(polygon, float), point, normal)
    if len(p) < 3:
        return 0.0
    a, edge = p - point, np.roll(p, -1, 0) - p
    c = np.cross(a, edge)
    size = np.linalg.norm(c, axis=1)
    use = size > 0
    gamma = np.arctan2(size, np.einsum("ij,ij->i", a, a + edge))
    return abs(np.sum(gamma[use] * (c[use] @ normal) / size[use])) / (2 * np.pi)


def lambert_on(polygon, positions, normal, emits_towards=None):
    """lambert() at every point of a (..., 3) array. With `emits_towards` zero behind the polygon's plane."""
    normal = np.asarray(normal, float)
    flat = positions.reshape(-1, 3)
    values = np.array([lambert(polygon, p, normal) for p in flat])
    if emits_towards is not None:
        values[(flat - polygon[0]) @ np.asarray(emits_towards, float) <= 0] = 0
    return values.reshape(positions.shape[:-1])


def parallel_rectangle(x, y, half, h):
    """Square of half side `half` at height h over the origin, parallel to the floor, from the floor's point (x, y).

    Sum of four corner forms F = (X / sqrt(1 + X^2) atan(Y / sqrt(1 + X^2)) + the same with X, Y exchanged) / (2 pi).
    """

    def corner(a, b):
        a, b = a / h, b / h
        ra, rb = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
        return (a / ra * np.arctan(b / ra) + b / rb * np.arctan(a / rb)) / (2 * np.pi)

    return (
        corner(x + half, y + half)
        - corner(x - half, y + half)
        - corner(x + half, y - half)
        + corner(x - half, y - half)
    )


def perpendicular_rectangle(a, b, c):
    """A rectangle of height a and width b that stands on the floor at distance c, one end before the point."""
    r = np.hypot(a, c)
    return (np.arctan(b / c) - c / r * np.arctan(b / r)) / (2 * np.pi)


def disk(radius, height, aside):
    """Parallel disk at some height, its centre `aside` from above the point."""
    s = aside**2 + height**2 + radius**2
    return 0.5 * (1 - (aside**2 + height**2 - radius**2) / np.sqrt(s * s - 4 * radius**2 * aside**2))


def cut_by_shadow(light_polygon, blocker_half_planes):
    """A light's polygon clipped by half planes (point, normal): what is left of it."""
    polygon = np.asarray(light_polygon, float)
    for point, normal in blocker_half_planes:
        polygon = clip(polygon, np.asarray(point, float), np.asarray(normal, float))
    return polygon


def triangles_of(positions, triangles):
    return np.asarray(positions, float)[np.asarray(triangles)]


def occluded(origins, targets, triangles):
    """Does any of (T, 3, 3) triangles lie between origins (N, 3) and targets (N, 3)? Moeller and Trumbore 1997,
    float64."""
    a, e1, e2 = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    hit = np.zeros(len(origins), bool)
    for begin in range(0, len(origins), 4096):
        part = slice(begin, begin + 4096)
        o, d = origins[part, None], (targets - origins)[part, None]
        p = np.cross(d, e2)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / np.einsum("nti,ti->nt", p, e1)
            s = o - a
            u = np.einsum("nti,nti->nt", s, p) * inverse
            q = np.cross(s, e1)
            v = np.einsum("nti,nti->nt", np.broadcast_to(d, q.shape), q) * inverse
            t = np.einsum("nti,ti->nt", q, e2) * inverse
            hit[part] = ((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-9) & (t < 1 - 1e-9)).any(axis=1)
    return hit


def summands(position, normal, matrix, size, points):
    """area x cos cos' / (pi r^2) for points (N, 2) of the unit square on a rectangular luminaire that emits towards
    its local -z, and the points' places (N, 3). The mean is the form factor."""
    local = np.column_stack([(points[:, 0] - 0.5) * size[0], (points[:, 1] - 0.5) * size[1], np.zeros(len(points))])
    places = local @ matrix[:3, :3].T + matrix[:3, 3]
    across = np.cross(matrix[:3, 0] * size[0], matrix[:3, 1] * size[1])
    area = np.linalg.norm(across)
    emitting = across / area * -np.sign(across @ matrix[:3, 2])
    d = places - position
    r2 = np.einsum("ij,ij->i", d, d)
    return np.maximum(d @ normal, 0) * np.maximum(-(d @ emitting), 0) * area / (np.pi * r2 * r2), places
