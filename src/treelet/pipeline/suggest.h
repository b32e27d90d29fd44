#pragma once

#include <span>
#include <string>
#include <string_view>

namespace treelet {

/// The end of an error about an unknown name: "; did you mean 'lbvh'? There are: lbvh, sweep".
std::string suggest(std::string_view unknown, std::span<const std::string_view> known);

}  // namespace treelet
