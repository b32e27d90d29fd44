"""Run a compiler and keep what it says beside the object file, as `<object>.log`.

python tools/keep_output.py nvcc -Xptxas=-v -c a.cu -o a.o

For CMAKE_CUDA_COMPILER_LAUNCHER: an incremental build compiles little, so the terminal does not show what
ptxas says about all kernels. The terminal gets the rest, such as warnings.
"""

import re
import subprocess
import sys
from pathlib import Path

# ptxas, asked for by -v: one line a fact, and the sizes of stack and spills on a line of their own.
REPORT_LINE = re.compile(r"ptxas info\s|\s+\d+ bytes stack frame,")


def main(command: list[str]) -> int:
    """Run the command and return its exit code."""
    answer = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if "-o" in command[:-1]:
        made = Path(command[command.index("-o") + 1])
        made.with_name(made.name + ".log").write_text(answer.stdout, encoding="utf-8")
    rest = [line for line in answer.stdout.splitlines() if not REPORT_LINE.match(line)]
    print(*rest, sep="\n", end="\n" if rest else "", file=sys.stderr)
    return answer.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
