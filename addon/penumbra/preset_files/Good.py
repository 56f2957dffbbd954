# SPDX-License-Identifier: GPL-3.0-or-later
# For most pictures: antialiased, within 1 % of white.
import bpy

settings = bpy.context.scene.penumbra

settings.stop_rule = "BOUNDED"
settings.error_tolerance = 0.01
settings.sampler = "OWEN_SOBOL"
settings.sample_reuse = "SCRAMBLED"
settings.light_samples = 64
settings.max_light_samples = 8192
settings.check_interval = 5
settings.pixel_samples = 16
settings.max_pixel_samples = 8192
