#pragma once

#include <span>
#include <string>
#include <string_view>

namespace treelet::peers {

/// An object of JSON, written member by member; numbers that are not finite become null.
class JsonObject {
 public:
  void add(std::string_view name, double value);
  void add(std::string_view name, std::string_view value);
  void add(std::string_view name, std::span<const double> values);
  void add(std::string_view name, const JsonObject& value);
  /// All members of another object.
  void merge(const JsonObject& other);

  bool is_empty() const { return members_.empty(); }
  /// On one line.
  std::string text() const { return "{" + members_ + "}"; }

 private:
  void add_raw(std::string_view name, std::string_view json);

  std::string members_;
};

}  // namespace treelet::peers
