#pragma once

#include <string>
#include <vector>

namespace treelet::test {

/// Each builder with each layout, bare at the defaults and at the ends of the layout's parameters,
/// with each optimizer, and with an optimizer and each splitter; trials of splits with lbvh alone.
std::vector<std::string> every_recipe();

}  // namespace treelet::test
