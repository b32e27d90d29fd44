#pragma once

#include <memory>
#include <string_view>

#include "peers/contender.h"
#include "peers/embree_options.h"

namespace treelet::peers {

/// Embree as parse_embree_options reads the text. Embree shares the caller's arrays, as its manual
/// recommends, so its memory is that of the tree alone.
std::unique_ptr<Contender> make_embree_contender(std::string_view text);

}  // namespace treelet::peers
