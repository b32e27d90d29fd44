"""`treelet render`: a picture of a mesh."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import typer

from treelet.cli.options import (
    JsonOption,
    MeshArgument,
    RecipeOption,
    SeedOption,
    SizeOption,
    ThreadsOption,
    TrianglesOption,
    ViewOption,
)


class Mode(str, Enum):
    """What the picture shows."""

    path = "path"
    ao = "ao"
    normals = "normals"
    depth = "depth"
    heat = "heat"


class Device(str, Enum):
    """Where tree and picture are made."""

    cpu = "cpu"
    cuda = "cuda"


OutputOption = Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="PNG file to write.")]
_MODE_HELP = "Path tracing, ambient occlusion, normals, depth, or traversal cost."
ModeOption = Annotated[Mode, typer.Option("--mode", "-m", help=_MODE_HELP)]
EyeOption = Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Camera position; needs --look-at.")]
LookAtOption = Annotated[
    str | None, typer.Option(metavar="X,Y,Z", help="Point in the middle of the picture.")
]
UpOption = Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Direction upwards in the picture.")]
FovOption = Annotated[float | None, typer.Option(metavar="DEGREES", help="Vertical angle of the picture.")]
SamplesOption = Annotated[int, typer.Option("--samples", "-s", metavar="N", min=1, help="Rays a pixel.")]
_BOUNCES_HELP = "Surfaces a path touches, 1 = direct light."
BouncesOption = Annotated[int, typer.Option(metavar="N", min=1, help=_BOUNCES_HELP)]
_EXPOSURE_HELP = "Brightness factor; measured if not given."
ExposureOption = Annotated[float | None, typer.Option(metavar="F", help=_EXPOSURE_HELP)]
_DENOISE_HELP = "Filter the noise of few samples."
_DEVICE_HELP = "Where to build and trace; cuda needs cupy."
DeviceOption = Annotated[Device, typer.Option("--device", help=_DEVICE_HELP)]
DenoiseOption = Annotated[bool, typer.Option("--denoise/--no-denoise", help=_DENOISE_HELP)]


def render(
    mesh: MeshArgument,
    output: OutputOption = Path("treelet.png"),
    mode: ModeOption = Mode.path,
    view: ViewOption = None,
    eye: EyeOption = None,
    look_at: LookAtOption = None,
    up: UpOption = None,
    fov: FovOption = None,
    size: SizeOption = "1280x800",
    samples: SamplesOption = 32,
    bounces: BouncesOption = 4,
    exposure: ExposureOption = None,
    denoise: DenoiseOption = True,
    recipe: RecipeOption = "balanced",
    triangles: TrianglesOption = None,
    seed: SeedOption = 0,
    device: DeviceOption = Device.cpu,
    threads: ThreadsOption = 0,
    json: JsonOption = False,
) -> None:
    """Render a mesh as a PNG picture."""
    from treelet.cli.inputs import load_subject, parse_size, use_threads
    from treelet.cli.output import note, print_json, progress_bar
    from treelet.render import RenderSettings, save_png
    from treelet.render import render as render_picture

    use_threads(threads)
    width, height = parse_size(size)
    settings = RenderSettings(width, height, samples, bounces, seed, exposure=exposure, denoise=denoise)
    _check_output(output)
    _check_device(device)
    subject = load_subject(mesh, triangles, seed)
    camera = _camera(subject, view, {"eye": eye, "look_at": look_at, "up": up}, fov, width / height)
    bvh, traced = _build(subject, recipe, device)
    with progress_bar(f"render {mode.value}") as bar:
        picture = render_picture(bvh, traced, camera, mode.value, settings, bar.at)
    save_png(output, picture)
    note(f"wrote {output}")
    if json:
        rows, columns = picture.shape[:2]
        facts = {"file": str(output), "mode": mode.value, "width": columns, "height": rows}
        print_json(facts | {"device": device.value, "view": _view_facts(camera)})


def _check_output(output: Path) -> None:
    if output.suffix.lower() != ".png":
        raise ValueError(
            f"--output is '{output}', but pictures are written as PNG: give a name that ends in .png"
        )


def _check_device(device: Device) -> None:
    """Say what is missing before a large mesh is read."""
    if device is Device.cpu:
        return
    from treelet import cuda
    from treelet.render.arrays import import_cupy

    if not cuda.is_available():
        raise ValueError(f"--device cuda: {cuda.why_unavailable()}")
    import_cupy()


def _build(subject: Any, recipe: str, device: Device) -> tuple[Any, Any]:
    """The tree over a mesh, and the mesh where the tree is."""
    import treelet

    if device is Device.cpu:
        return treelet.build(subject.vertices, subject.faces, recipe=recipe), subject
    from treelet.render import upload_mesh

    mesh = upload_mesh(subject)
    try:
        return treelet.build(mesh.vertices, mesh.faces, recipe=recipe), mesh
    except RuntimeError as error:  # a recipe word that only the host has, or what CUDA says
        raise ValueError(f"--device cuda: {error}") from error


def _camera(
    subject: Any, view: str | None, vectors: dict[str, str | None], fov: float | None, aspect: float
) -> Any:
    """The chosen view with whatever --eye, --look-at, --up and --fov replace in it."""
    from dataclasses import replace

    from treelet.cli.inputs import choose_view, parse_vector

    if (vectors["eye"] is None) != (vectors["look_at"] is None):
        raise ValueError("--eye and --look-at belong together: give both, or neither")
    given = {
        name: parse_vector(f"--{name.replace('_', '-')}", text)
        for name, text in vectors.items()
        if text is not None
    }
    if fov is not None:
        given["fov_degrees"] = fov
    return replace(choose_view(subject, view, aspect), **given)


def _view_facts(view: Any) -> dict[str, Any]:
    vectors = {name: [float(value) for value in getattr(view, name)] for name in ("eye", "look_at", "up")}
    return {"name": view.name, **vectors, "fov_degrees": float(view.fov_degrees)}
