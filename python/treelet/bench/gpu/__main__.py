"""Measures builds and queries on a CUDA device, and prints one `Measurement` a line.

    python -m treelet.bench.gpu [--parts rays,calls] [--scenes city] [--triangles 10000] [--output gpu.jsonl]

Parts: "copy", the bandwidth of the device's memory; "calls", what a call from Python costs; "rays", primary,
diffuse and occlusion rays through every recipe, layout and order; "stream", rays from the host's memory;
"queries", all hits, nearest points and containment; "builds", by stage, and updates of trees whose vertices
moved; "versus", other tracers on the same rays. But for "stream" all that a call takes lies on the device
already. Needs no array library. What the file of --output holds already is not measured again, so that a run
that ended early goes on.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import fields
from pathlib import Path

import treelet
from treelet import cuda, scenes
from treelet.bench.arguments import list_of, open_output, whole_number
from treelet.bench.gpu.cases import HOST_WORDS, Recipe, Settings, layouts, list_recipes, warn
from treelet.bench.gpu.tasks import PART_NAMES, finished_tasks, list_tasks, run
from treelet.scenes import catalog

UNFINISHED = 3  # the exit code where time ended before the measurements


def _read_scene(text: str) -> str:
    known = [*scenes.names(), *scenes.external_names()]
    if text not in known:
        raise argparse.ArgumentTypeError(f"unknown scene {text!r}{catalog.suggestion(text, known)}")
    return text


def _read_recipe(text: str) -> Recipe:
    try:
        words = treelet.parse_recipe(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return Recipe(text, host=any(word in words for word in HOST_WORDS))


def _one_of(names: Sequence[str], what: str) -> Callable[[str], str]:
    def read(text: str) -> str:
        if text not in names:
            raise argparse.ArgumentTypeError(f"unknown {what} {text!r}: choose from {', '.join(names)}")
        return text

    return read


def _parser() -> argparse.ArgumentParser:
    count = whole_number(catalog.FEWEST_TRIANGLES, catalog.MOST_TRIANGLES)
    parser = argparse.ArgumentParser(
        prog="python -m treelet.bench.gpu", description=(__doc__ or "").splitlines()[0]
    )
    add = parser.add_argument
    commas = "with commas between them"
    add("--parts", type=list_of(_one_of(PART_NAMES, "part")), default=PART_NAMES, help=", ".join(PART_NAMES))
    add("--scenes", type=list_of(_read_scene), default=(), help=commas)
    add("--triangles", type=list_of(count), default=(), help=f"of embedded scenes, {commas}")
    add("--recipe", "-r", type=_read_recipe, action="append", help="repeatable; by default many")
    add("--layouts", type=list_of(_one_of(layouts(), "layout")), default=(), help=f"of these, {commas}")
    add("--repeats", type=whole_number(1), default=Settings.repeats)
    add(
        "--width", type=whole_number(16), default=Settings.width, help="of the pictures whose rays are traced"
    )
    add("--calls", type=whole_number(1), default=Settings.calls, help="repeats of the part of that name")
    add("--call-rays", type=whole_number(1), default=Settings.call_rays, help="rays of each of these calls")
    add("--stream-rays", type=whole_number(1), default=Settings.stream_rays, help="rays of the part stream")
    add("--seconds", type=whole_number(1), default=10**9, help="begin nothing that may take longer")
    add("--output", type=Path, help="append the lines to this file")
    return parser


def _settings(options: argparse.Namespace) -> Settings:
    return Settings(**{field.name: getattr(options, field.name) for field in fields(Settings)})


def main(arguments: Sequence[str] | None = None) -> int:
    """The command: 1 where there is no GPU or an answer is not the CPU's, 3 where measurements are left."""
    parser = _parser()
    options = parser.parse_args(arguments)
    wrong: list[str] = []
    with open_output(parser, options.output, "a") if options.output else nullcontext() as file:
        if not cuda.is_available():
            warn(cuda.why_unavailable())
            return 1
        try:
            done = finished_tasks(options.output)
        except ValueError as error:
            parser.error(str(error))
        tasks = list(list_tasks(options.parts, options.scenes, options.triangles))
        tasks = [task for task in tasks if task.key not in done]
        settings = _settings(options)
        recipes = options.recipe or list_recipes(options.layouts)

        def write(lines: list[str]) -> None:
            text = "".join(line + "\n" for line in lines)
            print(text, end="", flush=True)  # noqa: T201
            wrong.extend(line for line in lines if json.loads(line)["details"].get("disagreements"))
            if file is not None:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())

        left = run(tasks, recipes, settings, options.seconds, write)
    if left:
        warn(f"no time left for: {', '.join(task.key for task in left)}; run it again")
    return 1 if wrong else UNFINISHED if left else 0


if __name__ == "__main__":
    sys.exit(main())
