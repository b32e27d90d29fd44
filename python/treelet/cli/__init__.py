"""The command line program. `main` is the entry point; nothing heavy is imported before a command runs."""

from __future__ import annotations

import sys
from collections.abc import Sequence

INTERRUPTED = 130  # exit code: 128 and the number of SIGINT, as shells have it


def main(arguments: Sequence[str] | None = None) -> None:
    """Run `treelet` with `arguments` (the process's own by default) and leave with its exit code."""
    try:
        from treelet.cli.app import app

        app(args=arguments, prog_name="treelet")
    except ImportError as missing:
        if missing.name not in ("typer", "rich"):
            raise
        sys.exit(f"The command line needs {missing.name}: pip install 'treelet[cli]'")
    except KeyboardInterrupt:  # before a command runs; `reported` has those of commands
        sys.stderr.write("interrupted\n")
        sys.exit(INTERRUPTED)
