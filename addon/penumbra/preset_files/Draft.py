# SPDX-License-Identifier: GPL-3.0-or-later
# To look at: without antialiasing, differences below 2 % of white are not worth a ray.
import bpy

settings = bpy.context.scene.penumbra

settings.stop_rule = "BOUNDED"
settings.error_tolerance = 0.02
settings.sampler = "OWEN_SOBOL"
settings.sample_reuse = "SCRAMBLED"
settings.light_samples = 64
settings.max_light_samples = 8192
settings.check_interval = 5
settings.pixel_samples = 1
settings.max_pixel_samples = 8192
