#pragma once

#include <memory>
#include <string_view>

#include "peers/contender.h"

namespace treelet::peers {

/// A preset or recipe of this library, under its own text.
std::unique_ptr<Contender> make_treelet_contender(std::string_view recipe);

}  // namespace treelet::peers
