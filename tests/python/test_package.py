"""What the installed package consists of."""

import ast
import subprocess
import sys
from pathlib import Path

import treelet
from treelet import _core


def test_import_is_light():
    heavy = ["matplotlib", "typer", "rich", "trimesh", "PIL", "scipy", "embreex", "treelet.mesh"]
    code = f"import sys, treelet; print([name for name in {heavy} if name in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_public_names_exist():
    assert sorted(treelet.__all__) == treelet.__all__
    assert all(hasattr(treelet, name) for name in treelet.__all__)
    assert all(getattr(treelet, name).__doc__ for name in treelet.__all__ if name != "__version__")


def test_public_names_are_listed_before_they_are_imported():
    code = "import treelet; print(set(treelet.__all__) - set(dir(treelet)), hasattr(treelet, 'Mash'))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.split() == ["set()", "False"]


def test_package_is_typed():
    assert Path(treelet.__file__).with_name("py.typed").exists()
    stub = ast.parse(Path(_core.__file__).with_name("_core.pyi").read_text())
    stubbed = {node.name for node in stub.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    assert stubbed == {name for name in dir(_core) if not name.startswith("_")}


def test_version():
    assert treelet.__version__.count(".") == 2
