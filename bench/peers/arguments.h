#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "peers/race.h"

namespace treelet::peers {

/// The command line of treelet_peers.
struct Arguments {
  std::filesystem::path scene;
  std::vector<std::string> contenders;
  RacePlan plan;
  unsigned threads = 0;  ///< 0: one a hardware thread
};

inline constexpr const char* kUsage =
    "treelet_peers SCENE [--contender=TEXT]... [--builds=N] [--repeats=N] [--threads=N]\n"
    "SCENE is a file that bench/peers/scene_file.py wrote. A TEXT is embree:low, embree:medium or\n"
    "embree:high, with +robust or +compact behind it, or embree-tree:high and so on, Embree's "
    "tree\n"
    "in this library's layout, with +budget=N or +block=N, or a recipe. One JSON line a "
    "measurement\n"
    "goes to the standard output.\n";

/// Throws std::invalid_argument.
Arguments parse_arguments(const std::vector<std::string>& words);

}  // namespace treelet::peers
