# SPDX-License-Identifier: GPL-3.0-or-later
# Ohbuchi and Aono's own: one ray a pixel, Sobol' points that go on from pixel to pixel, their stop rule.
import bpy

settings = bpy.context.scene.penumbra

settings.stop_rule = "PAPER"
settings.error_tolerance = 0.004
settings.sampler = "SOBOL"
settings.sample_reuse = "CONTINUED"
settings.light_samples = 64
settings.max_light_samples = 1024
settings.check_interval = 5
settings.pixel_samples = 1
settings.max_pixel_samples = 8192
