"""What surrounds CUDA: the list of kernels' resources, and requirements said twice."""

import json
import sys

import pytest
from loaded_tools import ROOT, load_tool

keep_output = load_tool("keep_output")
kernel_resources = load_tool("kernel_resources")

SOURCE = "src/treelet/core/cuda_device.cu"  # logs of files that are no more are left out

LOG = """\
ptxas info    : 28 bytes gmem
ptxas info    : Compiling entry function '{kernel}' for 'sm_90'
ptxas info    : Function properties for {kernel}
    16 bytes stack frame, {spill} bytes spill stores, 4 bytes spill loads
ptxas info    : Used 79 registers, used 1 barriers, 47104 bytes smem, 352 bytes cmem[0]
ptxas info    : Function properties for _ZN7treelet4cuda7forwardEPf
    8 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads
ptxas info    : Compiling entry function 'plain' for 'sm_90'
ptxas info    : Function properties for plain
    0 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads
ptxas info    : Used 10 registers, used 0 barriers
"""


@pytest.fixture
def build(tmp_path):
    """A folder as a build leaves it."""
    log = tmp_path / "CMakeFiles" / "treelet_kernels.dir" / f"{SOURCE}.o.log"
    log.parent.mkdir(parents=True)
    log.write_text(LOG.format(kernel="_ZN7treelet4cuda4sortIjEEvPT_", spill=12))
    return tmp_path


def test_reads_what_each_function_uses():
    sort, forward, plain = kernel_resources.parse_log(LOG.format(kernel="sort", spill=12), "a.cu")
    assert (sort.name, sort.architecture, sort.is_kernel) == ("sort", "sm_90", True)
    assert (sort.registers, sort.spill_stores, sort.spill_loads, sort.stack, sort.shared) == (
        79,
        12,
        4,
        16,
        47104,
    )
    assert (forward.is_kernel, forward.stack, forward.spills) == (False, 8, False)
    assert (plain.registers, plain.shared, plain.spills) == (10, 0, False)


def test_spilling_fails_unless_allowed(build, capsys):
    assert kernel_resources.main([str(build)]) == 1
    printed = capsys.readouterr()
    assert "sort" in printed.err
    assert "plain" in printed.out
    [name] = {
        kernel_resources.short_name(each.name) for each in kernel_resources.read_build(build) if each.spills
    }
    assert kernel_resources.main([str(build), "--allow-spill", "other", name]) == 0
    assert kernel_resources.main([str(build), "--allow-spill", "sor*"]) == 0


def test_table_is_aligned_markdown(build, capsys):
    kernel_resources.main([str(build)])
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 + 3
    assert len({len(line) for line in lines}) == 1
    assert {line.count("|") for line in lines} == {8}


def test_json_has_a_line_a_function(build, capsys):
    kernel_resources.main([str(build), "--json"])
    records = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {record["source"] for record in records} == {"core/cuda_device.cu"}
    assert sorted(record["registers"] for record in records) == [0, 10, 79]


def test_a_build_without_kernels_is_an_error(tmp_path, capsys):
    assert kernel_resources.main([str(tmp_path)]) == 2
    assert "make cuda" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "short"),
    [
        ("treelet::cuda::(anonymous namespace)::refit(treelet::Span<int>, unsigned int)", "refit"),
        ("void treelet::cuda::form<(treelet::Kind)1, 7>(float*)", "form<(Kind)1, 7>"),
        ("void cub::CUB_1::detail::Sort<cub::CUB_1::policy<unsigned int, true>, int>(int*)", "cub Sort<...>"),
        ("_Zmangled", "_Zmangled"),
    ],
)
def test_names_are_shortened(name, short):
    assert kernel_resources.short_name(name) == short


def test_output_is_kept_beside_the_object_and_the_rest_is_shown(tmp_path, capsys):
    made = tmp_path / "a.cu.o"
    says = LOG.format(kernel="sort", spill=0) + "a.cu(3): warning: unused\n"
    command = [sys.executable, "-c", f"print({says!r}, end=''); raise SystemExit(3)", "-o", str(made)]
    assert keep_output.main(command) == 3
    assert (tmp_path / "a.cu.o.log").read_text() == says
    assert capsys.readouterr().err == "a.cu(3): warning: unused\n"


def test_one_cuda_toolkit_is_required_everywhere():
    requirement = "cuda-toolkit[nvcc,cccl]==13.0.*"
    assert (ROOT / "pyproject.toml").read_text().count(f'"{requirement};') == 2
    assert f'"{requirement}"' in (ROOT / "cmake" / "TreeletCuda.cmake").read_text()
