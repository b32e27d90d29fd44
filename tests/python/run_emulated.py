"""Runs tests of arrays in device memory on the emulated device: run_emulated.py FOLDER [pytest arguments].

FOLDER holds the package that the target treelet_emulated_python makes. An editable installation would hide
it: its import hook comes first and is taken out here.
"""

import sys
from pathlib import Path

sys.meta_path = [finder for finder in sys.meta_path if "ScikitBuild" not in type(finder).__name__]
sys.path.insert(0, sys.argv[1])

import pytest  # noqa: E402

import treelet  # noqa: E402

if not Path(treelet.__file__).is_relative_to(Path(sys.argv[1]).absolute()):
    sys.exit(f"treelet came from {treelet.__file__}, not from {sys.argv[1]}")
if not treelet.cuda.is_available():
    sys.exit(f"the emulated device does not work: {treelet.cuda.why_unavailable()}")
sys.exit(pytest.main(["-p", "no:cacheprovider", *sys.argv[2:]]))
