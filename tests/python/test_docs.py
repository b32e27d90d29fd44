"""What the documentation shows runs as it stands there."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import treelet

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES, PICTURES = ROOT / "examples", ROOT / "docs" / "images" / "guides"
DRAWING = [
    pytest.param("ambient_occlusion", marks=pytest.mark.slow),
    "lidar",
    "signed_distance",
    "sun_hours",
    "viewshed",
]


@pytest.mark.parametrize("name", DRAWING)
def test_draws_the_picture_of_its_guide(name, tmp_path):
    pytest.importorskip("matplotlib")
    image = pytest.importorskip("PIL.Image")
    path = tmp_path / f"{name}.png"
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    command = [sys.executable, str(EXAMPLES / f"{name}.py"), str(path)]
    answer = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.count("\n") == 1
    assert path.stat().st_size < 400_000
    with image.open(path) as drawn, image.open(PICTURES / path.name) as shown:
        assert drawn.size == shown.size


TRIANGLE = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
"""


def test_quickstart_prints_what_it_says(tmp_path, monkeypatch, capsys):
    (tmp_path / "bunny.ply").write_text(TRIANGLE)
    monkeypatch.chdir(tmp_path)
    code = "".join(re.findall(r"```python\n(.*?)```", (ROOT / "docs/quickstart.md").read_text(), re.DOTALL))
    exec(compile(code, "quickstart.md", "exec"), {})
    promised = re.findall(r"^print\(.*\)  # (.*)$", code, re.MULTILINE)
    printed = capsys.readouterr().out.splitlines()
    assert len(promised) >= 3
    assert [line for line in printed if line in promised] == promised


def test_reference_has_every_public_name():
    text = (ROOT / "docs/reference.md").read_text()
    documented = set(re.findall(r"^\.\. auto\w+:: treelet\.(\w+)", text, re.MULTILINE))
    assert set(treelet.__all__) - {"__version__"} - documented == set()


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"])
def test_links_between_files_lead_somewhere(page):
    targets = re.findall(r"\]\((?!\w+:|#)([^)#\s]+)", (ROOT / page).read_text())
    assert [target for target in targets if not (ROOT / target).exists()] == []
