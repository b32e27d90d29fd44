#include "peers/json.h"

#include <charconv>
#include <cmath>
#include <cstdint>

namespace treelet::peers {
namespace {

/// Counts as whole numbers, not as 1e+06.
std::string number(double value) {
  if (!std::isfinite(value)) return "null";
  if (value == std::trunc(value) && std::abs(value) < 1e15)
    return std::to_string(std::int64_t(value));
  char text[32];
  return {text, std::to_chars(text, text + sizeof(text), value).ptr};
}

std::string quoted(std::string_view value) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text = "\"";
  for (const char c : value) {
    if (static_cast<unsigned char>(c) < 0x20) {
      text += std::string("\\u00") + digits[std::size_t(c) >> 4] + digits[std::size_t(c) & 15];
      continue;
    }
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + "\"";
}

}  // namespace

void JsonObject::add(std::string_view name, double value) { add_raw(name, number(value)); }

void JsonObject::add(std::string_view name, std::string_view value) {
  add_raw(name, quoted(value));
}

void JsonObject::add(std::string_view name, std::span<const double> values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + number(value);
  add_raw(name, "[" + text + "]");
}

void JsonObject::add(std::string_view name, const JsonObject& value) {
  add_raw(name, value.text());
}

void JsonObject::merge(const JsonObject& other) {
  if (!members_.empty() && !other.members_.empty()) members_ += ", ";
  members_ += other.members_;
}

void JsonObject::add_raw(std::string_view name, std::string_view json) {
  if (!members_.empty()) members_ += ", ";
  members_ += quoted(name) + ": " + std::string(json);
}

}  // namespace treelet::peers
