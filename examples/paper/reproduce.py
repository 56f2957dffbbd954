# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper, reproduced: measures everything with Penumbra inside Blender, draws the figures and writes the report.

    blender -b --factory-startup --python-exit-code 1 -P examples/paper/reproduce.py -- [--quick] [--only NAME ...]

Data flows one way: scenes -> measure/ (CSV) -> draw/ (figures) -> tell/ (report). With --only the other experiments'
numbers of the run before are kept; without it everything old is deleted first.
"""

import argparse
import importlib
import json
import os
import platform
import shutil
import sys
import time
import traceback
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.path[:0] = [str(FOLDER), str(FOLDER.parent)]

import sizes  # noqa: E402  (found through the line above)
from tables import Data  # noqa: E402

EXPERIMENTS = ("points", "stride", "crops", "running_mean", "picture_error", "matched_rays", "bound", "brdf")
OUTPUT = FOLDER / "output"


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="reproduce.py")
    parser.add_argument("--quick", action="store_true", help="smaller pictures, under five minutes")
    parser.add_argument("--only", nargs="*", choices=EXPERIMENTS, help="measure these again, or none")
    parser.add_argument("--output", type=Path, default=OUTPUT)
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])


def measure(data: Data, size: sizes.Size, names, run: dict) -> None:
    """Runs the experiments; `run`: what the report says about this run, kept in run.json."""
    from engine import pn

    run |= {"size": size.name, "machine": f"{os.cpu_count()} CPUs, {platform.machine()}, {pn.isa}", "build": pn.build,
            "version": pn.__version__}  # fmt: skip
    for name in names:
        begin = time.perf_counter()
        importlib.import_module(f"measure.{name}").measure(data, size)
        run["seconds"][name] = round(time.perf_counter() - begin, 1)
        print(f"Measured {name} in {run['seconds'][name]} s", flush=True)
    (data.folder / "run.json").write_text(json.dumps(run, indent=2) + "\n", encoding="utf-8")


def tell(data: Data, output: Path) -> None:
    """Draws all figures and writes the report, from the numbers alone."""
    from tell import report

    figures = output / "figures"
    figures.mkdir(exist_ok=True)
    for name in EXPERIMENTS:
        importlib.import_module(f"draw.{name}").draw(data, figures)
    report.write(data, output)


def main() -> None:
    arguments = parse_arguments()
    size = sizes.QUICK if arguments.quick else sizes.FULL
    if arguments.only is None:
        shutil.rmtree(arguments.output, ignore_errors=True)
    data = Data(arguments.output / "data")
    kept = data.folder / "run.json"
    run = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {"size": size.name, "seconds": {}}
    if run["size"] != size.name:
        raise RuntimeError(f"the output folder holds a {run['size']} run: leave --only out")
    measure(data, size, EXPERIMENTS if arguments.only is None else arguments.only, run)
    tell(data, arguments.output)
    print(f"Wrote {arguments.output / 'report.html'}", flush=True)


if __name__ == "__main__":
    try:
        main()
        code = 0
    except Exception as error:
        traceback.print_exc()
        print(f"reproduce.py: {error}", file=sys.stderr)
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    sys.exit(code)
