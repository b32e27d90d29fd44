"""Check that no file has more than 500 lines and no function more than 60.

Python functions are measured from ``def`` to their end, without the docstring. C++ functions are
found by their braces: a block whose head has a parameter list, outside any other function.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

FILE_LIMIT = 500
FUNCTION_LIMIT = 60
ROOTS = ("src", "python", "tests", "tools", "bench", "examples")
CPP_SUFFIXES = {".h", ".inl", ".cpp", ".cu", ".cuh"}


class Function(NamedTuple):
    """A function's name, the line it starts at (from 1) and its length in lines."""

    name: str
    line: int
    length: int


def python_functions(text: str) -> Iterator[Function]:
    """Yield every function and method, nested ones too."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            length = _line_count(node) - _docstring_length(node)
            yield Function(node.name, node.lineno, length)


def _line_count(node: ast.stmt) -> int:
    return (node.end_lineno or node.lineno) - node.lineno + 1


def _docstring_length(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    return _line_count(node.body[0]) if ast.get_docstring(node, clean=False) is not None else 0


# What hides braces from the eye: comments, literals, and preprocessor lines (a macro's body may
# be unbalanced). Raw strings come before plain ones, whose rules they break.
CPP_OPAQUE = re.compile(
    r"""//[^\n]* | /\*.*?\*/
      | R"(?P<mark>[^(\s"]*)\(.*?\)(?P=mark)"
      | "(?:\\.|[^"\\\n])*" | (?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'
      | ^[ \t]*\#(?:[^\n\\]|\\.)*""",
    re.VERBOSE | re.DOTALL | re.MULTILINE,
)
CPP_SCOPE = re.compile(r"\s*(?:(?:inline|export)\s+)?(?:namespace|extern)\b")
CPP_TYPE = re.compile(r"\s*(?:template\s*<[^{]*?>\s*)?(?:typedef\s+)?(?:class|struct|union|enum)\b")
CPP_PARAMETERS = re.compile(r"([~\w]+|operator\s*[^\s\w]+)\s*\(")
CPP_MEMBER_INITIALIZER = re.compile(r"\)\s*(?:noexcept\s*)?:(?!:).*[\w>]\s*$", re.DOTALL)


class Block(NamedTuple):
    """An open brace: the function it is the body of, if any, and where the head before it began."""

    function: Function | None
    head_start: int
    is_expression: bool


def cpp_functions(text: str) -> Iterator[Function]:
    """Yield every function defined at namespace or class scope; lambdas count to their function."""
    text = CPP_OPAQUE.sub(_blank, text)
    head_start = 0
    blocks: list[Block] = []
    for match in re.finditer(r"[{};]", text):
        if match[0] == "{":
            inside_function = any(block.function for block in blocks)
            blocks.append(_open_block(text, head_start, match.start(), inside_function))
        elif match[0] == "}" and blocks:
            block = blocks.pop()
            if block.function:
                last_line = _line_of(text, match.start())
                yield block.function._replace(length=last_line - block.function.line + 1)
            if block.is_expression:
                head_start = block.head_start
                continue
        head_start = match.end()


def _blank(match: re.Match[str]) -> str:
    return "\n" * match[0].count("\n") or " "


def _line_of(text: str, position: int) -> int:
    return text.count("\n", 0, position) + 1


def _open_block(text: str, start: int, brace: int, inside_function: bool) -> Block:
    head = text[start:brace]
    # A default argument ``f(Config c = {})`` or a member initializer ``X() : a{1} {`` is no body.
    is_expression = head.count("(") > head.count(")") or bool(CPP_MEMBER_INITIALIZER.search(head))
    function = None if inside_function or is_expression else _function_of_head(text, start, head)
    return Block(function, start, is_expression)


def _function_of_head(text: str, start: int, head: str) -> Function | None:
    """Return the function whose body this head opens, its length unknown, or None."""
    parameters = CPP_PARAMETERS.search(head)
    if not parameters or CPP_SCOPE.match(head) or CPP_TYPE.match(head):
        return None
    before = head[: parameters.start()]
    if "=" in before and "operator" not in before:
        return None
    first_character = start + len(head) - len(head.lstrip())
    return Function(parameters[1], _line_of(text, first_character), 0)


def check_file(file: Path) -> Iterator[str]:
    """Yield a message for the file and for each of its functions above the limit."""
    text = file.read_text(encoding="utf-8")
    line_count = len(text.splitlines())
    if line_count > FILE_LIMIT:
        yield f"{file}: {line_count} lines, the limit is {FILE_LIMIT}"
    functions = python_functions(text) if file.suffix == ".py" else cpp_functions(text)
    for name, line, length in functions:
        if length > FUNCTION_LIMIT:
            yield f"{file}:{line}: {name} has {length} lines, the limit is {FUNCTION_LIMIT}"


def check_tree(root: Path) -> list[str]:
    """Return all violations in the source folders of the project at ``root``."""
    files = [file for folder in ROOTS for file in sorted((root / folder).rglob("*"))]
    sources = [file for file in files if file.suffix in CPP_SUFFIXES | {".py"}]
    return [violation for file in sources for violation in check_file(file)]


def main() -> int:
    """Check the project given as argument, by default the current folder; return the exit code."""
    violations = check_tree(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
    print("\n".join(violations) if violations else "sizes: clean")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
