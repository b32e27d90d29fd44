#include "peers/treelet_contender.h"

#include <treelet/pipeline/build.h>

#include "peers/bvh_contender.h"

namespace treelet::peers {
namespace {

class TreeletContender final : public BvhContender {
 public:
  explicit TreeletContender(std::string_view recipe)
      : label_(recipe), recipe_(parse_recipe(recipe)) {}

  std::string label() const override { return label_; }
  std::string recipe() const override { return recipe_.text(); }

 private:
  Bvh build_bvh(const Mesh& mesh) override { return treelet::build(mesh, recipe_); }

  std::string label_;
  Recipe recipe_;
};

}  // namespace

std::unique_ptr<Contender> make_treelet_contender(std::string_view recipe) {
  return std::make_unique<TreeletContender>(recipe);
}

}  // namespace treelet::peers
