"""Name the build tools (CMake, Ninja) that must come from PyPI, as pip requirements on one line.

A tool counts as present when it runs and is new enough; what this prints is empty when all are.
"""

import re
import subprocess

REQUIRED = {"cmake": (3, 25), "ninja": (1, 10)}


def installed_version(tool: str) -> tuple[int, ...] | None:
    """Return the version of a tool on PATH, or None when it is missing or broken."""
    try:
        answer = subprocess.run([tool, "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    match = re.search(r"(\d+)\.(\d+)", answer.stdout)
    return tuple(map(int, match.groups())) if match else None


def missing_requirements() -> list[str]:
    """Return pip requirements, such as ``cmake>=3.25``, for the tools that are missing or old."""
    return [
        f"{tool}>={'.'.join(map(str, oldest))}"
        for tool, oldest in REQUIRED.items()
        if (installed_version(tool) or (0,)) < oldest
    ]


if __name__ == "__main__":
    print(" ".join(missing_requirements()))
