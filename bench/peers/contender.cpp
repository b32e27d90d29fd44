#include "peers/contender.h"

#include "peers/embree_contender.h"
#include "peers/embree_tree_contender.h"
#include "peers/embree_tree_options.h"
#include "peers/treelet_contender.h"

namespace treelet::peers {

std::unique_ptr<Contender> make_contender(std::string_view text) {
  if (text.starts_with(kEmbreePrefix)) return make_embree_contender(text);
  if (text.starts_with(kEmbreeTreePrefix)) return make_embree_tree_contender(text);
  return make_treelet_contender(text);
}

}  // namespace treelet::peers
