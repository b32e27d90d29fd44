#include "peers/race.h"

#include <chrono>
#include <utility>

#include "peers/agreement.h"

namespace treelet::peers {
namespace {

/// A contender's way to answer a set of rays, and its timings so far.
struct Entrant {
  const Contender& contender;
  Query query;
  Timing timing;
};

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Calls run(index, is_counted) for each of `count`, round by round; each round starts with
/// another, and the first is for warming up.
template <class Run>
void take_turns(std::size_t count, int rounds, Run&& run) {
  for (int round = 0; round <= rounds; ++round) {
    for (std::size_t i = 0; i < count; ++i) run((i + std::size_t(round)) % count, round > 0);
  }
}

void race_builds(const Contenders& contenders, const Mesh& mesh, const RacePlan& plan,
                 const Progress& progress, std::vector<Timing>& timings) {
  std::vector<std::vector<double>> samples(contenders.size());
  take_turns(contenders.size(), plan.builds, [&](std::size_t i, bool is_counted) {
    Contender& contender = *contenders[i];
    progress("build " + contender.label());
    contender.drop();
    const double seconds = seconds_of([&] { contender.build(mesh); });
    if (is_counted) samples[i].push_back(seconds);
  });
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    const Contender& contender = *contenders[i];
    timings.push_back(
        {"build", contender.label(), contender.recipe(), 0, samples[i], contender.describe_tree()});
  }
}

std::vector<Query> queries_of(const RaySet& rays) {
  if (rays.any_hit) return {Query::any};
  if (rays.kind == "primary") return {Query::closest, Query::packets};
  return {Query::closest};
}

std::vector<Entrant> entrants_for(const Contenders& contenders, const RaySet& rays) {
  std::vector<Entrant> entrants;
  for (const auto& contender : contenders) {
    for (const Query query : queries_of(rays)) {
      if (!contender->can_answer(query)) continue;
      const std::string label = contender->label() + (query == Query::packets ? " packets" : "");
      entrants.push_back({*contender,
                          query,
                          {rays.kind, label, contender->recipe(), rays.origins.size(), {}, {}}});
    }
  }
  return entrants;
}

void race_rays(const Contenders& contenders, const RaySet& rays, const RacePlan& plan,
               const Progress& progress, std::vector<Timing>& timings) {
  const RayBatch batch = rays.batch();
  std::vector<Entrant> entrants = entrants_for(contenders, rays);
  Answers expected(batch.size), answers(batch.size);
  entrants.front().contender.answer(entrants.front().query, batch, expected);
  take_turns(entrants.size(), plan.repeats, [&](std::size_t i, bool is_counted) {
    auto& [contender, query, timing] = entrants[i];
    if (!is_counted) answers = Answers(batch.size);  // none of the last contender's
    progress("trace " + rays.kind + " rays with " + timing.label);
    const double seconds = seconds_of([&] { contender.answer(query, batch, answers); });
    if (is_counted) {
      timing.samples.push_back(seconds);
    } else {
      timing.details = contender.count_work(batch);
      timing.details.add("differing", share_of_differences(query, expected, answers));
      timing.details.add("unequal", share_of_unequal_bits(query, expected, answers));
    }
  });
  for (Entrant& entrant : entrants) timings.push_back(std::move(entrant.timing));
}

}  // namespace

std::vector<Timing> race(const Contenders& contenders, const SceneFile& scene, const RacePlan& plan,
                         const Progress& progress) {
  std::vector<Timing> timings;
  race_builds(contenders, scene.mesh(), plan, progress, timings);
  for (const RaySet& rays : scene.ray_sets) race_rays(contenders, rays, plan, progress, timings);
  return timings;
}

}  // namespace treelet::peers
