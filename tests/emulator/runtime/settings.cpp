#include <cstdlib>
#include <mutex>
#include <string>

#include "api.h"
#include "emulator/control.h"

namespace treelet::emulator {
namespace {

std::uint64_t read_number(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr || *text == '\0' ? otherwise : std::strtoull(text, nullptr, 0);
}

Settings read_environment() {
  Settings result;
  result.workers = unsigned(read_number("TREELET_EMULATOR_WORKERS", result.workers));
  result.seed = read_number("TREELET_EMULATOR_SEED", result.seed);
  result.has_device = read_number("TREELET_EMULATOR_NO_DEVICE", 0) == 0;
  result.memory_limit = read_number("TREELET_EMULATOR_MEMORY_LIMIT", result.memory_limit);
  return result;
}

Settings& current_settings() {
  static Settings current = read_environment();
  return current;
}

}  // namespace

std::recursive_mutex& api_mutex() {
  static auto* mutex = new std::recursive_mutex;  // calls may come while the program ends
  return *mutex;
}

Settings settings() {
  const std::lock_guard lock(api_mutex());
  return current_settings();
}

void set_settings(const Settings& wanted) {
  const std::lock_guard lock(api_mutex());
  current_settings() = wanted;
}

}  // namespace treelet::emulator
