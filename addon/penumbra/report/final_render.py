# SPDX-License-Identifier: GPL-3.0-or-later
"""Work inside a final render: only there does Blender evaluate a scene as it is rendered, and not as it is viewed."""

from collections.abc import Callable

import bpy


def inside(scene, work: Callable):
    """Renders `scene` with an engine that lives for this call, and returns work(engine, depsgraph).

    What `work` raises is raised here; RuntimeError if Blender does not start the render (a scene without a camera).
    """
    outcome: dict[str, object] = {}

    class Engine(bpy.types.RenderEngine):
        bl_idname = "PENUMBRA_REPORT"
        bl_label = "Penumbra: speed against error"
        bl_use_preview = False

        def render(self, depsgraph):
            try:
                outcome["result"] = work(self, depsgraph)
            except BaseException as error:  # Blender would only print it
                outcome["error"] = error

    own = scene.render.engine
    bpy.utils.register_class(Engine)
    try:
        scene.render.engine = Engine.bl_idname
        bpy.ops.render.render(scene=scene.name)
    finally:
        scene.render.engine = own
        bpy.utils.unregister_class(Engine)
    if "error" in outcome:
        raise outcome["error"]
    if "result" not in outcome:
        raise RuntimeError("Blender did not start the render")
    return outcome["result"]
