#pragma once

#include <gtest/gtest.h>

#include <string>

#include "support/meshes.h"

namespace treelet::test {

/// Names the tests of INSTANTIATE_TEST_SUITE_P after their meshes.
inline std::string mesh_name(const testing::TestParamInfo<NamedMesh>& parameter) {
  return parameter.param.name;
}

}  // namespace treelet::test
