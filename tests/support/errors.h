#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace treelet::test {

/// The message of the Error that `run` throws.
template <class Error = std::invalid_argument, class Run>
std::string error_of(Run&& run) {
  try {
    run();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

}  // namespace treelet::test
