#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace treelet::test {

/// The message of the std::invalid_argument that `run` throws.
template <class Run>
std::string error_of(Run&& run) {
  try {
    run();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

}  // namespace treelet::test
