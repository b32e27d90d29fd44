#pragma once

#include <stdexcept>

namespace treelet {

/// A file that holds no tree that can be used: foreign, damaged, cut off, or of another version.
/// What the system refuses is a std::system_error instead.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace treelet
