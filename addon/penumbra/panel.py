# SPDX-License-Identifier: GPL-3.0-or-later
"""What all of Penumbra's panels share."""


class PropertiesPanel:
    """A panel of the properties editor, for this engine only."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"PENUMBRA"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def column(self):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout.column()
