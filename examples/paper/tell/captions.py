# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands below each figure, by the name of its file."""

from measure import brdf, crops, stride

CAPTIONS = {
    "fig1": "Fig. 1: the first 16 points of each kind. The grid has 16 cells; SPRS and Owen-Sobol' have one point "
    "in each.",
    "fig2": "Fig. 2: the first coordinate of Numerical Recipes' Sobol' sequence alternates between the halves of "
    "[0, 1], so every other point misses half of the square.",
    "stride": f"The left end of the sphere's shadow with {stride.POINTS} Sobol' points a pixel: striding draws "
    "vertical lines, and a pixel that takes only the even points sees half of the luminaire.",
    "fig4": "Fig. 4: a sphere on the ground under a square luminaire, rendered by Blender with "
    f"{crops.WHOLE_POINTS} Owen-Sobol' points a pixel. The frame is the crop of Fig. 5.",
    "fig5": f"Fig. 5: its penumbra with {crops.POINTS} points a pixel; above the pictures, below their errors "
    "against a converged picture.",
    "fig6": "Fig. 6: radiance at two points of the floor, against the number of points on the luminaire.",
    "fig7": "Fig. 7: error of the whole picture. Above the root mean square, below the mean absolute error, which "
    "is what the paper's eq. (5) and (6) say as printed; left the bare ground (exact reference: Lambert's closed "
    "form), right with the sphere (converged reference).",
    "fig7_treatments": "The same for each treatment from pixel to pixel, with more points; PRS in red for comparison.",
    "fig7_penumbra": "RMS error over the floor's penumbra (10 to 90 % of the light arrive), relative to the unshadowed "
    "radiance. Dashed: the slopes that theory has for random points and for evenly spread ones before an edge.",
    "fig8": "Fig. 8: four objects under a square luminaire, rendered by Blender with QMC-EBLS.",
    "fig9": "Fig. 9: a crop of the penumbra, rays matched; below their errors. QMC is Sobol' with the same points "
    "in each pixel.",
    "fig9_points": "Where the points went.",
    "time_and_rays": "CPU seconds against rays; the least of several rounds.",
    "bound": "Share of pixels whose true error is above the eps asked for. The black line is 1 %; what is below "
    "0.01 % is drawn there.",
    "bound_map": "Where the paper's rule misses at eps = 0.004.",
    "brdf": "All three terms, made with Blender's nodes and rendered by Blender: spheres of half Diffuse and half "
    f"Glossy BSDF with roughness {', '.join(f'{r:g}' for r in brdf.ROUGHNESSES)}, before a Glossy BSDF of roughness 0.",
    "brdf_lobes": "The highlight of a small luminaire on glossy planes.",
}
