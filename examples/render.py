# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a .blend file with Penumbra, without a window:

    blender -b FILE.blend -P examples/render.py -- [--output OUT.exr] [--frame N | --frames A-B]
        [--statistics S.json] [--set NAME=VALUE ...] [--multilayer] [--view VIEW.png] [--checkpoint DIR]
    blender -b FILE.blend -P examples/render.py -- --debug-pixel X,Y [--frame N] [--set NAME=VALUE ...]
    blender -b FILE.blend -P examples/render.py -- --report DIR [--report-pixels N] [--frame N] [--set NAME=VALUE ...]
    blender -b -P examples/penumbra_addon.py FILE.blend -P examples/render.py -- ...    where the add-on is not enabled:
        else Blender says "Error: Engine 'PENUMBRA' not available" of a file that was saved with it, and goes on

Every option may be left out; without --output the scene's own path and format are used. The exit code is 0 only if
every picture is there, whole: it is written to a temporary file beside its place, read back, then renamed. Any failure
ends in one line that says why.
"""

import argparse
import os
import sys
import traceback
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))

import penumbra_addon  # noqa: E402  (found through the line above)
from check_picture import BadPicture, check_picture  # noqa: E402

FORMATS = {
    ".exr": "OPEN_EXR", ".png": "PNG", ".tif": "TIFF", ".tiff": "TIFF", ".jpg": "JPEG", ".jpeg": "JPEG", ".hdr": "HDR",
}  # fmt: skip


class Failure(Exception):
    """Ends the run with this one line."""


def frame_range(text: str) -> range:
    first, dash, last = text.partition("-")
    if not (first.isdigit() and dash and last.isdigit() and int(first) <= int(last)):
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form A-B with A <= B")
    return range(int(first), int(last) + 1)


def pixel(text: str) -> tuple[int, int]:
    x, comma, y = text.partition(",")
    if not (x.isdigit() and comma and y.isdigit()):
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form X,Y")
    return int(x), int(y)


def parse_arguments() -> argparse.Namespace:
    """What follows `--` on Blender's command line."""
    parser = argparse.ArgumentParser(prog="render.py", usage="blender -b FILE.blend -P render.py -- [options]")
    parser.add_argument(
        "--output", type=Path, help="the picture; its extension chooses the format, .exr is 32-bit float"
    )
    frames = parser.add_mutually_exclusive_group()
    frames.add_argument("--frame", type=int, help="the frame to render; the file's current one if left out")
    frames.add_argument("--frames", type=frame_range, metavar="A-B", help="the frames to render, #### in names: number")
    parser.add_argument("--statistics", type=Path, help="JSON file of what the render did")
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE",
                        help="a setting of scene.penumbra, such as error_tolerance=0.002")  # fmt: skip
    parser.add_argument("--multilayer", action="store_true", help="write all passes into the .exr file")
    parser.add_argument("--view", type=Path, help="a .png as the screen shows it, beside the picture")
    parser.add_argument(
        "--checkpoint", type=Path, metavar="DIR", help="keep finished tiles there, and go on from those that are there"
    )
    parser.add_argument(
        "--debug-pixel",
        type=pixel,
        metavar="X,Y",
        help="tell of one pixel (origin bottom left), no picture",
    )
    parser.add_argument("--report", type=Path, metavar="DIR", help="write a page on speed against error, no picture")
    parser.add_argument("--report-pixels", type=int, metavar="N", help="scale the report's frame to so many pixels")
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])


def apply_setting(settings, text: str) -> None:
    """Sets NAME=VALUE on scene.penumbra; Failure if there is no such setting or the value does not fit it."""
    name, equals, value = text.partition("=")
    known = {p.identifier: p for p in settings.bl_rna.properties if p.identifier not in ("rna_type", "name")}
    if not equals:
        raise Failure(f"--set {text}: expected NAME=VALUE")
    if name not in known:
        raise Failure(f"--set {name}: there is no such setting; there are {', '.join(known)}")
    rna = known[name]
    if rna.type == "ENUM":
        if value not in rna.enum_items:
            raise Failure(f"--set {name}: {value!r} is none of {', '.join(rna.enum_items.keys())}")
    elif rna.type in ("INT", "FLOAT"):
        kind = int if rna.type == "INT" else float
        try:
            value = kind(value)
        except ValueError:
            raise Failure(f"--set {name}: {value!r} is not a{'n integer' if kind is int else ' number'}") from None
        if not rna.hard_min <= value <= rna.hard_max:
            raise Failure(f"--set {name}: {value} is not between {rna.hard_min:g} and {rna.hard_max:g}")
    setattr(settings, name, value)


def numbered(path: Path | None, frame: int, many: bool) -> Path | None:
    """The path for one frame: #### replaced by its number, or the number put before the extension if there are many."""
    if path is None:
        return None
    if many and "#" not in path.name:
        path = path.with_name(f"{path.stem}####{path.suffix}")
    hashes = path.name.count("#")
    return path.with_name(path.name.replace("#" * hashes, f"{frame:0{hashes}d}") if hashes else path.name).absolute()


def choose_format(scene, arguments: argparse.Namespace, package) -> None:
    """Sets the scene's file format after the extension of --output; the scene's own is kept without one."""
    image = scene.render.image_settings
    if arguments.output is None:
        if scene.render.is_movie_format:
            raise Failure(f"the scene's own format, {image.file_format}, is a movie: give --output")
        return
    suffix = arguments.output.suffix.lower()
    if suffix not in FORMATS:
        raise Failure(f"--output {arguments.output}: unknown extension {suffix!r}; there are {', '.join(FORMATS)}")
    if arguments.multilayer and suffix != ".exr":
        raise Failure(f"--multilayer needs an .exr file, not {arguments.output.name}")
    package.compat.set_file_format(image, "OPEN_EXR_MULTILAYER" if arguments.multilayer else FORMATS[suffix])
    if suffix == ".exr":
        image.color_depth = "32"


def save_view(scene, path: Path, package) -> None:
    """Writes the last render through the scene's view transform, as 8-bit PNG."""
    image = scene.render.image_settings
    package.compat.set_file_format(image, "PNG")
    image.color_mode, image.color_depth = "RGBA", "8"
    bpy.data.images["Render Result"].save_render(str(path), scene=scene)


def render_frame(scene, frame: int, target: Path, package) -> dict:
    """Renders one frame into `target` and returns its statistics; nothing is left behind if anything fails."""
    if not target.parent.is_dir():
        raise Failure(f"the folder {target.parent} does not exist")
    if not any(layer.use for layer in scene.view_layers):  # Blender 3.4 would write a black picture, as EXR crash
        raise Failure(f"scene {scene.name!r}: no view layer is used for rendering")
    camera = package.export.camera
    size = camera.frame_size(scene)
    if scene.render.use_border and scene.render.use_crop_to_border:
        size = camera.render_region(scene)[2:]
    temporary = target.with_name(f".{target.stem}.{os.getpid()}.tmp{target.suffix}")
    scene.render.filepath, scene.render.use_file_extension = str(temporary), False
    package.statistics.last_render = None
    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
        statistics = package.statistics.last_render
        if statistics is None or statistics["cancelled"]:
            raise Failure("the render was cancelled")
        check_picture(temporary, size)
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)
    return statistics


def write_report(arguments: argparse.Namespace, package) -> None:
    """Renders the scene with many settings and writes the page that compares them."""
    unused = ("output", "frames", "statistics", "multilayer", "view", "checkpoint")
    if given := [f"--{name}" for name in unused if getattr(arguments, name)]:
        raise Failure(f"--report writes no picture: leave {', '.join(given)} out")
    scene, report = bpy.context.scene, package.report
    if arguments.frame is not None:
        scene.frame_set(arguments.frame)
    most = report.DEFAULT_PIXELS if arguments.report_pixels is None else max(arguments.report_pixels, 1)
    print(f"{'Report':16} {report.write_report(scene, bpy.context.view_layer, arguments.report, most)}")


def debug_pixel(arguments: argparse.Namespace, package) -> None:
    """Prints what happens in one pixel of each view layer."""
    scene = bpy.context.scene
    if arguments.frame is not None:
        scene.frame_set(arguments.frame)
    package.engine.debug_pixel = arguments.debug_pixel
    try:
        bpy.ops.render.render(scene=scene.name)
    finally:
        package.engine.debug_pixel = None


def main() -> None:
    arguments = parse_arguments()
    package = penumbra_addon.load()
    scene = bpy.context.scene
    scene.render.engine = penumbra_addon.ENGINE
    if scene.render.engine != penumbra_addon.ENGINE:
        raise Failure("Blender did not take Penumbra as the render engine")
    for text in arguments.set:
        apply_setting(scene.penumbra, text)
    if arguments.report:
        write_report(arguments, package)
        return
    if arguments.debug_pixel:
        debug_pixel(arguments, package)
        return
    if arguments.checkpoint:
        scene.penumbra.checkpoint_folder = str(arguments.checkpoint.absolute())
    choose_format(scene, arguments, package)
    own_path = scene.render.frame_path  # by Blender's own rules
    frames = arguments.frames or [scene.frame_current if arguments.frame is None else arguments.frame]
    targets = {
        frame: numbered(arguments.output, frame, len(frames) > 1) or Path(bpy.path.abspath(own_path(frame=frame)))
        for frame in frames
    }
    if arguments.output is None:  # as Blender does
        next(iter(targets.values())).parent.mkdir(parents=True, exist_ok=True)
    for frame, target in targets.items():
        scene.frame_set(frame)
        if arguments.statistics:
            scene.penumbra.statistics_file = str(numbered(arguments.statistics, frame, len(frames) > 1))
        statistics = render_frame(scene, frame, target, package)
        print(f"{'Picture':16} {target}")
        for name, text in package.statistics.summary(statistics):
            print(f"{name:16} {text}")
    if arguments.view:
        save_view(scene, arguments.view.absolute(), package)
        print(f"{'View':16} {arguments.view.absolute()}")


def run() -> int:
    """main() with every failure turned into one line and an exit code."""
    try:
        main()
    except (Failure, BadPicture, RuntimeError, OSError) as error:
        lines = [line.removeprefix("Error: ") for line in str(error).strip().splitlines()]  # Blender's reports
        print(f"render.py: {'; '.join(lines)}", file=sys.stderr)
    except Exception as error:
        traceback.print_exc()
        print(f"render.py: {type(error).__name__}: {error}", file=sys.stderr)
    else:
        return 0
    return 1


if __name__ == "__main__" and (code := run()):
    sys.stdout.flush()
    sys.stderr.flush()
    sys.exit(code)
