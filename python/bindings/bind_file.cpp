#include <array>
#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <treelet/file/load.h>
#include <treelet/file/save.h>
#include <treelet/layout/mesh_hash.h>

#include "arrays.h"
#include "bindings.h"

namespace nb = nanobind;
using namespace nb::literals;
using Path = std::filesystem::path;
using Offset = std::array<double, 3>;

namespace {

/// Runs without the GIL; what the system refuses becomes an OSError with the file's name.
template <class Use>
auto use_file(const Path& path, Use&& use) {
  try {
    const nb::gil_scoped_release release;
    return use();
  } catch (const std::system_error& error) {
    errno = error.code().value();
    PyErr_SetFromErrnoWithFilename(PyExc_OSError, path.string().c_str());
    throw nb::python_error();
  }
}

void save(const treelet::Bvh& bvh, const Path& path) {
  use_file(path, [&] { treelet::save(bvh, path); });
}

treelet::Bvh load(const Path& path, bool map, bool verify) {
  return use_file(path, [&] { return treelet::load(path, {.map = map, .verify = verify}); });
}

nb::dict read_info(const Path& path) {
  const treelet::FileInfo info = use_file(path, [&] { return treelet::read_info(path); });
  nb::dict facts;
  facts["version"] = info.version;
  facts["layout"] = std::string(info.layout);
  facts["bytes"] = info.bytes;
  facts["mesh_hash"] = info.mesh_hash;
  return facts;
}

nb::bytes to_bytes(const treelet::Bvh& bvh) {
  treelet::Array<std::byte> bytes;
  {
    const nb::gil_scoped_release release;
    bytes = treelet::to_bytes(bvh);
  }
  return nb::bytes(bytes.data(), bytes.size());
}

treelet::Bvh from_bytes(const nb::bytes& bytes) {
  const std::span view(static_cast<const std::byte*>(bytes.data()), bytes.size());
  const nb::gil_scoped_release release;
  return treelet::from_bytes(view);
}

std::uint64_t hash_mesh(const Vec3Array& vertices, const FaceArray& faces, const Offset& offset) {
  const treelet::Mesh mesh = as_mesh(vertices, faces);
  const nb::gil_scoped_release release;
  treelet::check_indices(mesh);
  return treelet::hash_mesh(mesh, offset);
}

std::uint64_t hash_tree(const treelet::Bvh& bvh) {
  const nb::gil_scoped_release release;
  return std::visit(
      [&](const auto& layout) {
        return treelet::hash_mesh(layout, bvh.report.faces, bvh.placement.offset);
      },
      bvh.layout);
}

nb::tuple placement(const treelet::Bvh& bvh) {
  const auto& [offset, rounding] = bvh.placement;
  return nb::make_tuple(nb::make_tuple(offset[0], offset[1], offset[2]), rounding);
}

void place(treelet::Bvh& bvh, const Offset& offset, double rounding) {
  bvh.placement = {offset, rounding};
}

}  // namespace

void bind_file(nb::module_& module) {
  nb::exception<treelet::FileError>(module, "FileError", PyExc_ValueError).attr("__doc__") =
      "A file that holds no usable tree: foreign, damaged, cut off or of another version.";
  module.def("save", save, "bvh"_a, "path"_a);
  module.def("load", load, "path"_a, "map"_a, "verify"_a);
  module.def("read_file_info", read_info, "path"_a);
  module.def("to_bytes", to_bytes, "bvh"_a);
  module.def("from_bytes", from_bytes, "bytes"_a);
  module.def("hash_mesh", hash_mesh, "vertices"_a.noconvert(), "faces"_a.noconvert(), "offset"_a);
  module.def("hash_tree", hash_tree, "bvh"_a);
  module.def("placement", placement, "bvh"_a);
  module.def("place", place, "bvh"_a, "offset"_a, "rounding"_a);
}
