"""The checks of ``make lint`` find what they are there to find, and nothing else."""

import sys
from pathlib import Path

import pytest
from loaded_tools import ROOT, load_tool

check_layers = load_tool("check_layers")
check_sizes = load_tool("check_sizes")
missing_build_tools = load_tool("missing_build_tools")


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


class TestLayers:
    @pytest.mark.parametrize("include", ["<treelet/core/vec.h>", "<treelet/tree/tree.h>", "<vector>"])
    def test_accepts_own_folder_and_folders_to_the_left(self, tmp_path, include):
        write(tmp_path / "tree" / "refit.cpp", f"#include {include}\n")
        assert check_layers.check_tree(tmp_path) == []

    @pytest.mark.parametrize(
        ("include", "message"),
        [
            ("<treelet/build/lbvh.h>", "tree may not include build"),
            ("<treelet/tools/x.h>", "in no known folder"),
            ("<treelet/treelet.h>", "is for users"),
            ('"../core/vec.h"', "include"),
        ],
    )
    def test_rejects_everything_else_with_its_place(self, tmp_path, include, message):
        file = write(tmp_path / "tree" / "refit.cpp", f"#pragma once\n#  include {include}\n")
        [violation] = check_layers.check_tree(tmp_path)
        assert violation.startswith(f"{file}:2: ")
        assert message in violation

    def test_rejects_an_unknown_folder(self, tmp_path):
        write(tmp_path / "misc" / "x.h", "")
        [violation] = check_layers.check_tree(tmp_path)
        assert "misc is not a layer" in violation

    def test_lets_the_umbrella_header_include_all(self, tmp_path):
        write(tmp_path / "treelet.h", "#include <treelet/pipeline/pipeline.h>\n")
        assert check_layers.check_tree(tmp_path) == []

    def test_the_project_is_clean(self):
        assert check_layers.check_tree(ROOT / "src" / "treelet") == []


def cpp_lengths(text: str) -> dict[str, int]:
    return {function.name: function.length for function in check_sizes.cpp_functions(text)}


class TestCppFunctions:
    def test_measures_free_functions_from_signature_to_brace(self):
        text = "namespace a {\n\nint sum(int a,\n        int b) {\n  return a + b;\n}\n\n}  // namespace\n"
        [function] = check_sizes.cpp_functions(text)
        assert function == ("sum", 3, 4)

    def test_finds_methods_of_nested_and_templated_types(self):
        text = """
        template <typename T>
        struct alignas(16) Outer : Base<T> {
          class Inner { void first() { if (x) { y(); } } };
          bool operator==(const Outer& o) const { return true; }
          int second() const noexcept {
            return 2;
          }
        };
        enum class Kind { one, two };
        """
        assert cpp_lengths(text) == {"first": 1, "operator==": 1, "second": 3}

    def test_counts_a_lambda_to_its_function(self):
        assert cpp_lengths("void f() {\n  g([&](int i) {\n    h(i);\n  });\n}\n") == {"f": 5}

    def test_is_not_misled_by_braces_that_open_no_body(self):
        text = """
        constexpr Table table = make({1, 2});
        void defaults(Config config = {}, Ray ray = {1, 2}) {
          use(config);
        }
        Pool::Pool(int n) : count_{n}, workers_{} {
          start();
        }
        """
        assert cpp_lengths(text) == {"defaults": 3, "Pool": 3}

    def test_is_not_misled_by_braces_in_comments_literals_and_macros(self):
        text = """
        #define OPEN(x) \\
          if (x) {
        int f() {  // }
          /* } */
          g("}", '}', 1'000, R"x(}")x");
          return 1;
        }
        """
        assert cpp_lengths(text) == {"f": 5}


class TestSizes:
    def test_a_docstring_does_not_count_to_its_function(self):
        text = 'def f():\n    """One.\n\n    Two.\n    """\n    return 1\n'
        [function] = check_sizes.python_functions(text)
        assert function == ("f", 1, 2)

    @pytest.mark.parametrize(("lines", "violations"), [(60, 0), (61, 1)])
    def test_functions_up_to_the_limit_pass(self, tmp_path, lines, violations):
        body = "  x();\n" * (lines - 2)
        write(tmp_path / "src" / "a.cpp", f"void f() {{\n{body}}}\n")
        write(tmp_path / "python" / "a.py", "def f():\n" + "    x()\n" * (lines - 1))
        assert len(check_sizes.check_tree(tmp_path)) == 2 * violations

    @pytest.mark.parametrize(("lines", "violations"), [(500, 0), (501, 1)])
    def test_files_up_to_the_limit_pass(self, tmp_path, lines, violations):
        write(tmp_path / "src" / "a.h", "\n" * lines)
        write(tmp_path / "tools" / "a.py", "\n" * lines)
        assert len(check_sizes.check_tree(tmp_path)) == 2 * violations

    def test_the_project_is_clean(self):
        assert check_sizes.check_tree(ROOT) == []


class TestMissingBuildTools:
    @pytest.mark.parametrize(
        ("answers", "expected"),
        [
            ({"cmake": "cmake version 3.25.1", "ninja": "1.11.1"}, []),
            ({"cmake": "cmake version 3.22.0", "ninja": "1.11.1"}, ["cmake>=3.25"]),
            ({}, ["cmake>=3.25", "ninja>=1.10"]),
        ],
    )
    @pytest.mark.skipif(sys.platform == "win32", reason="stand-in tools are shell scripts")
    def test_names_what_is_missing_or_old(self, tmp_path, monkeypatch, answers, expected):
        for tool, answer in answers.items():
            write(tmp_path / tool, f"#!/bin/sh\necho '{answer}'\n").chmod(0o755)
        monkeypatch.setenv("PATH", str(tmp_path))
        assert missing_build_tools.missing_requirements() == expected


@pytest.mark.skipif(sys.version_info < (3, 11), reason="tomllib came with Python 3.11")
def test_group_build_repeats_the_build_requirements():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert project["dependency-groups"]["build"] == project["build-system"]["requires"]
