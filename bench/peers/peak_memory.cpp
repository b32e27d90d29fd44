#include "peers/peak_memory.h"

#include <sys/wait.h>
#include <unistd.h>

#include <exception>
#include <fstream>
#include <string>

namespace treelet::peers {
namespace {

/// A figure of /proc/self/status, in bytes; -1 where there is none.
double status_bytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == name + ":" && status >> kilobytes) return kilobytes * 1024;
  }
  return -1;
}

/// Makes the highest resident memory the present one. [man proc_pid_clear_refs]
bool reset_peak() { return bool(std::ofstream("/proc/self/clear_refs") << 5 << std::flush); }

double measure_here(const std::function<void()>& warm_up, const std::function<void()>& work) {
  warm_up();
  if (!reset_peak()) return -1;
  const double before = status_bytes("VmRSS");
  work();
  const double peak = status_bytes("VmHWM");
  return before < 0 || peak < 0 ? -1 : peak - before;
}

/// What the child does: measures, tells its parent, and ends without destructors, which are for
/// the parent's objects.
[[noreturn]] void run_child(int to_parent, const std::function<void()>& warm_up,
                            const std::function<void()>& work) {
  double bytes = -1;
  try {
    bytes = measure_here(warm_up, work);
  } catch (const std::exception&) {
    // The parent meets the same error when it builds, and says so.
  }
  const bool is_told = write(to_parent, &bytes, sizeof(bytes)) == sizeof(bytes);
  _exit(is_told ? 0 : 1);
}

}  // namespace

std::optional<double> measure_peak_memory(const std::function<void()>& warm_up,
                                          const std::function<void()>& work) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) run_child(ends[1], warm_up, work);
  close(ends[1]);
  double bytes = -1;
  const bool is_told = child > 0 && read(ends[0], &bytes, sizeof(bytes)) == sizeof(bytes);
  close(ends[0]);
  if (child > 0) waitpid(child, nullptr, 0);
  if (!is_told || bytes < 0) return {};
  return bytes;
}

}  // namespace treelet::peers
