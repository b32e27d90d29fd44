#include <treelet/core/parallel.h>

#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>

#include "peers/arguments.h"
#include "peers/contender.h"
#include "peers/peak_memory.h"
#include "peers/race.h"
#include "peers/scene_file.h"

namespace treelet::peers {
namespace {

void show_progress(const std::string& step) { std::fprintf(stderr, "  %s\n", step.c_str()); }

/// What building takes at its worst beside the mesh; threads and code pages are there before.
std::optional<double> measure_build_memory(const std::string& text, const Mesh& mesh) {
  const std::vector<Vec3> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}};
  const std::vector<Face> face = {{0, 1, 2}};
  const Mesh triangle{{corners.data(), 3}, face};
  std::unique_ptr<Contender> contender;
  const auto warm_up = [&] {
    contender = make_contender(text);
    contender->build(triangle);
    contender->drop();
  };
  return measure_peak_memory(warm_up, [&] { contender->build(mesh); });
}

std::string json_line(const Timing& timing, std::optional<double> peak_bytes) {
  JsonObject details = timing.details;
  if (peak_bytes && timing.kind == "build") details.add("peak_bytes", *peak_bytes);
  JsonObject line;
  line.add("kind", timing.kind);
  line.add("label", timing.label);
  line.add("recipe", timing.recipe);
  line.add("rays", double(timing.rays));
  line.add("threads", double(thread_count()));
  line.add("samples", timing.samples);
  line.add("details", details);
  return line.text();
}

void run(const Arguments& arguments) {
  const SceneFile scene = read_scene_file(arguments.scene);
  set_thread_count(arguments.threads);
  // First of all, for this process must not have threads yet.
  std::vector<std::optional<double>> peaks;
  for (const std::string& text : arguments.contenders) {
    show_progress("measure the memory to build " + text);
    peaks.push_back(measure_build_memory(text, scene.mesh()));
  }
  Contenders contenders;
  for (const std::string& text : arguments.contenders) contenders.push_back(make_contender(text));
  const std::vector<Timing> timings = race(contenders, scene, arguments.plan, show_progress);
  for (std::size_t i = 0; i < timings.size(); ++i) {  // builds come first, in the same order
    const std::optional<double> peak = i < peaks.size() ? peaks[i] : std::nullopt;
    std::printf("%s\n", json_line(timings[i], peak).c_str());
  }
}

}  // namespace
}  // namespace treelet::peers

int main(int argc, char** argv) {
  using namespace treelet::peers;
  try {
    run(parse_arguments({argv + 1, argv + argc}));
    return 0;
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "treelet_peers: %s\n%s", error.what(), kUsage);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "treelet_peers: %s\n", error.what());
    return 1;
  }
}
