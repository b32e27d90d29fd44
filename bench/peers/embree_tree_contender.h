#pragma once

#include <memory>
#include <string_view>

#include "peers/contender.h"

namespace treelet::peers {

/// Embree's builder, asked as parse_embree_tree_options reads the text, and after it the layout
/// bvh8 and the traversal of this library. What its build takes includes the way there and back
/// through Embree's callbacks: Embree's own scenes build faster.
std::unique_ptr<Contender> make_embree_tree_contender(std::string_view text);

}  // namespace treelet::peers
