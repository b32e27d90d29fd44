#include <span>
#include <string>
#include <vector>

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <treelet/pipeline/build.h>
#include <treelet/pipeline/choose_preset.h>
#include <treelet/pipeline/update.h>

#include "arrays.h"
#include "bindings.h"
#include "report.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

nb::str text(std::string_view view) { return nb::str(view.data(), view.size()); }

treelet::BuildOptions options(bool validate) {
  treelet::BuildOptions options;
  options.validate |= validate;
  return options;
}

std::span<const treelet::Vec3> as_vertices(const Vec3Array& vertices) {
  return {reinterpret_cast<const treelet::Vec3*>(vertices.data()), vertices.shape(0)};
}

treelet::Bvh build(const Vec3Array& vertices, const FaceArray& faces, const std::string& recipe,
                   bool validate) {
  const treelet::Mesh mesh = as_mesh(vertices, faces);
  const nb::gil_scoped_release release;
  return treelet::build(mesh, recipe, options(validate));
}

treelet::UpdatableBvh build_updatable(const Vec3Array& vertices, const FaceArray& faces,
                                      const std::string& recipe, bool validate) {
  const treelet::Mesh mesh = as_mesh(vertices, faces);
  const nb::gil_scoped_release release;
  return treelet::UpdatableBvh(mesh, recipe, options(validate));
}

void refit(treelet::UpdatableBvh& tree, const Vec3Array& vertices) {
  const std::span<const treelet::Vec3> moved = as_vertices(vertices);
  const nb::gil_scoped_release release;
  tree.refit(moved);
}

void rebuild(treelet::UpdatableBvh& tree, const Vec3Array& vertices) {
  const std::span<const treelet::Vec3> moved = as_vertices(vertices);
  const nb::gil_scoped_release release;
  tree.rebuild(moved);
}

nb::dict report(const treelet::Bvh& bvh) { return describe_report(bvh.report); }

nb::object bounds(const treelet::Bvh& bvh) {
  const treelet::Aabb box = bvh.bounds();
  return nb::make_tuple(nb::make_tuple(box.lower.x, box.lower.y, box.lower.z),
                        nb::make_tuple(box.upper.x, box.upper.y, box.upper.z));
}

double epo(const treelet::Bvh& bvh, std::size_t max_triangles) {
  const nb::gil_scoped_release release;
  return bvh.epo(max_triangles);
}

std::vector<std::string> validate_tree(const treelet::Bvh& bvh) {
  const nb::gil_scoped_release release;
  return bvh.validate();
}

std::vector<std::string> validate_against(const treelet::Bvh& bvh, const Vec3Array& vertices,
                                          const FaceArray& faces) {
  const treelet::Mesh mesh = as_mesh(vertices, faces);
  const nb::gil_scoped_release release;
  treelet::check_indices(mesh);
  return bvh.validate(mesh);
}

nb::list recipe_words() {
  nb::list words;
  for (const treelet::RecipeWord& word : treelet::recipe_words()) {
    nb::list parameters;
    for (const treelet::WordParameter& p : word.parameters) {
      parameters.append(nb::make_tuple(text(p.name), int(p.default_value), int(p.minimum),
                                       int(p.maximum), text(p.summary)));
    }
    words.append(nb::make_tuple(text(word.name), text(treelet::kind_name(word.kind)),
                                text(word.summary), parameters));
  }
  return words;
}

nb::list presets() {
  nb::list presets;
  for (const treelet::Preset& preset : treelet::presets()) {
    presets.append(nb::make_tuple(text(preset.name), text(preset.recipe), text(preset.summary)));
  }
  return presets;
}

}  // namespace

void bind_pipeline(nb::module_& module) {
  nb::class_<treelet::Bvh>(module, "Bvh")
      .def_prop_ro("report", report)
      .def_prop_ro("bounds", bounds)
      .def("epo", epo, "max_triangles"_a)
      .def("validate", validate_tree)
      .def("validate_against", validate_against, "vertices"_a.noconvert(), "faces"_a.noconvert());
  nb::class_<treelet::UpdatableBvh>(module, "UpdatableBvh")
      .def_prop_ro("bvh", &treelet::UpdatableBvh::bvh, nb::rv_policy::reference_internal)
      .def("refit", refit, "vertices"_a.noconvert())
      .def("rebuild", rebuild, "vertices"_a.noconvert())
      .def("require_vertex_count", &treelet::UpdatableBvh::require_vertex_count, "count"_a);
  module.def("build", build, "vertices"_a.noconvert(), "faces"_a.noconvert(), "recipe"_a,
             "validate"_a);
  module.def("build_updatable", build_updatable, "vertices"_a.noconvert(), "faces"_a.noconvert(),
             "recipe"_a, "validate"_a);
  module.def(
      "canonical_recipe",
      [](const std::string& recipe) { return treelet::parse_recipe(recipe).text(); }, "recipe"_a);
  module.def(
      "choose_preset",
      [](std::size_t triangles, double rays, bool may_split) {
        return std::string(may_split ? treelet::choose_preset(triangles, rays)
                                     : treelet::choose_unsplit_preset(triangles, rays));
      },
      "triangles"_a, "rays"_a, "may_split"_a);
  module.def("recipe_words", recipe_words);
  module.def("presets", presets);
}
