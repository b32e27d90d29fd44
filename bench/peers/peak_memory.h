#pragma once

#include <functional>
#include <optional>

namespace treelet::peers {

/// By how many bytes the resident memory of a process grows at most while work() runs, warm_up()
/// before it not counted. Both run in a child of this process, which must have no other threads
/// yet. Empty where the system does not tell (other than Linux), or where the child fails.
std::optional<double> measure_peak_memory(const std::function<void()>& warm_up,
                                          const std::function<void()>& work);

}  // namespace treelet::peers
