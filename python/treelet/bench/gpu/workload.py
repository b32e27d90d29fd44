"""What a profiler looks at: every builder, layout and kind of rays, each query once.

python -m treelet.bench.gpu.workload [--scene city] [--triangles 1000000] [--counters counters.csv]

With --counters it runs itself under Nsight Compute (ncu), which writes that file.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from treelet import cuda, scenes
from treelet.bench.arguments import whole_number
from treelet.bench.gpu.builds import build_all
from treelet.bench.gpu.cases import Case, list_recipes, order_arguments, warn
from treelet.bench.gpu.kernels import METRICS
from treelet.bench.gpu.rays import DeviceRays
from treelet.scenes import catalog


def run(case: Case, width: int) -> int:
    """Build and trace; returns the number of queries."""
    queries = 0
    ray_sets = [DeviceRays(rays) for rays in case.make_rays(width)]
    for subject in build_all(case, [recipe for recipe in list_recipes() if not recipe.host], 0):
        for rays in ray_sets:
            for _, order in order_arguments():
                rays.trace(subject.bvh, **order)
                queries += 1
    cuda.synchronize()
    return queries


def profile(arguments: Sequence[str], output: Path) -> int:
    """Run this module with other arguments under Nsight Compute; returns its exit code."""
    if shutil.which("ncu") is None:
        warn("Nsight Compute (ncu) is not on the PATH")
        return 1
    profiler = ["ncu", "--csv", "--page=raw", "--print-units=base", "--clock-control=none"]
    profiler += [f"--metrics={','.join(METRICS)}", f"--log-file={output}"]
    command = [*profiler, sys.executable, "-m", "treelet.bench.gpu.workload", *arguments]
    return subprocess.run(command, check=False).returncode


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; 1 where there is no GPU."""
    count = whole_number(catalog.FEWEST_TRIANGLES, catalog.MOST_TRIANGLES)
    parser = argparse.ArgumentParser(
        prog="python -m treelet.bench.gpu.workload", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("--scene", choices=scenes.names(), default="city")
    parser.add_argument("--triangles", type=count, default=1_000_000)
    parser.add_argument("--width", type=whole_number(16), default=1600)
    parser.add_argument("--counters", type=Path, metavar="FILE", help="let Nsight Compute write this")
    options = parser.parse_args(arguments)
    if options.counters:
        again = [f"--scene={options.scene}", f"--triangles={options.triangles}", f"--width={options.width}"]
        return profile(again, options.counters)
    if not cuda.is_available():
        warn(cuda.why_unavailable())
        return 1
    warn(f"{run(Case(options.scene, options.triangles), options.width)} queries")
    return 0


if __name__ == "__main__":
    sys.exit(main())
