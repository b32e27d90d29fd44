// Masks of rays and faces, and culling: what is hidden is as if it were not there.

#include <treelet/query/intersect.h>

#include <gtest/gtest.h>

#include <treelet/core/exact.h>
#include <treelet/pipeline/build.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/traverse/tracer.h>
#include <treelet/traverse/visitors.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "support/isas.h"
#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/random.h"

namespace treelet {
namespace {

constexpr const char* kRecipes[] = {"balanced", "lbvh > bvh2", "lbvh > cwbvh", "sbvh > bvh8"};
constexpr Cull kCulls[] = {Cull::none, Cull::back, Cull::front};

/// Flags for so many, about two thirds of them true.
class Flags {
 public:
  Flags(std::size_t count, std::uint64_t seed) : flags_(std::make_unique<bool[]>(count + 1)) {
    test::Random random(seed);
    for (std::size_t i = 0; i < count; ++i) flags_[i] = random.below(3) != 0;
  }
  bool operator[](std::size_t i) const { return flags_[i]; }
  const bool* data() const { return flags_.get(); }

 private:
  std::unique_ptr<bool[]> flags_;
};

bool is_shown(const FaceFilter& filter, const Mesh& mesh, const Ray& ray, std::size_t face) {
  if (filter.mask != nullptr && !filter.mask[face]) return false;
  const Triangle t = mesh.triangle(face);
  const double side = exact_triple_product(ray.direction, t.p0, t.p1, t.p2);
  return filter.cull == Cull::none || (side < 0.0) == (filter.cull == Cull::back);
}

/// The closest hit among the faces that are shown.
Hit expected_hit(const FaceFilter& filter, const Mesh& mesh, const Ray& ray) {
  ClosestHit<> visitor(ray);
  if (!is_traceable(ray)) return visitor.hit;
  const RayShear shear(ray);
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const Triangle triangle = mesh.triangle(face);
    TriangleHit hit;
    if (classify(triangle) != TriangleKind::regular) continue;
    if (!intersect_exactly(shear, triangle, hit) || !is_shown(filter, mesh, ray, face)) continue;
    visitor.visit(std::uint32_t(face), hit);
  }
  return visitor.hit;
}

/// Rays of a picture after those that tend to go wrong: packets are for them.
std::vector<Ray> rays_of(const Mesh& mesh) {
  std::vector<Ray> rays = test::rays_at(mesh, 40, 31);
  Aabb box = Aabb::empty();
  for (const Face& face : mesh.faces) {
    const Triangle t = mesh.triangle(std::size_t(&face - mesh.faces.data()));
    if (classify(t) == TriangleKind::regular) box = merge(box, bounds(t));
  }
  if (box.lower.x > box.upper.x) return rays;
  const Vec3 extent = box.extent();
  for (int i = 0; i < 256; ++i) {
    const Vec3 target = box.lower + Vec3{extent.x * float(i % 16) / 15,
                                         extent.y * float(i / 16) / 15, extent.z * 0.5f};
    const Vec3 eye = box.lower + Vec3{extent.x * 0.4f, extent.y * 0.6f, extent.z * 3 + extent.x};
    rays.push_back({eye, target - eye});
  }
  return rays;
}

class Filters : public testing::TestWithParam<test::NamedMesh> {
 protected:
  const Mesh mesh_ = GetParam().mesh.view();
  const std::vector<Ray> rays_ = rays_of(mesh_);
  const Flags faces_{mesh_.faces.size(), 32}, active_{rays_.size(), 33};
};

TEST_P(Filters, ShowClosestAndAnyHitsOfWhatIsThere) {
  for (const char* const recipe : kRecipes) {
    const Bvh bvh = build(mesh_, recipe);
    for (const Cull cull : kCulls) {
      for (const bool* const mask : {static_cast<const bool*>(nullptr), faces_.data()}) {
        RayBatch batch(rays_);
        batch.filter = {cull, mask};
        std::vector<Hit> hits(rays_.size());
        std::visit([&](const auto& tree) { intersect(tree, batch, std::span(hits)); }, bvh.layout);
        const auto found = std::make_unique<bool[]>(rays_.size());
        bvh.find_occluded(batch, {found.get(), rays_.size()});
        for (std::size_t i = 0; i < rays_.size(); ++i) {
          const Hit expected = expected_hit(batch.filter, mesh_, rays_[i]);
          ASSERT_EQ(hits[i], expected) << recipe << ", cull " << int(cull) << ", ray " << i;
          ASSERT_EQ(found[i], expected.is_hit()) << recipe << ", ray " << i;
        }
      }
    }
  }
}

TEST_P(Filters, ListAndCountAllHitsOfWhatIsThere) {
  for (const char* const recipe : kRecipes) {
    const Bvh bvh = build(mesh_, recipe);
    const AllHits all = bvh.intersect_all(RayBatch(rays_));
    for (const Cull cull : kCulls) {
      RayBatch batch(rays_);
      batch.filter = {cull, faces_.data()};
      batch.active = {active_.data(), 1};
      const AllHits shown = bvh.intersect_all(batch);
      std::vector<std::int64_t> counts(rays_.size());
      bvh.count_hits(batch, counts);
      std::size_t next = 0;
      for (std::size_t i = 0; i < rays_.size(); ++i) {
        const std::size_t first = next;
        for (auto k = std::size_t(all.offsets[i]); k < std::size_t(all.offsets[i + 1]); ++k) {
          if (!active_[i]) break;
          if (!is_shown(batch.filter, mesh_, rays_[i], std::size_t(all.face[k]))) continue;
          ASSERT_LT(next, shown.size()) << recipe << ", ray " << i;
          ASSERT_EQ(shown.face[next], all.face[k]) << recipe << ", ray " << i;
          ASSERT_EQ(shown.t[next++], all.t[k]);
        }
        ASSERT_EQ(std::size_t(shown.offsets[i + 1]), next) << recipe << ", ray " << i;
        ASSERT_EQ(std::size_t(counts[i]), next - first) << recipe << ", ray " << i;
      }
    }
  }
}

TEST_P(Filters, GiveTheSameAnswersOnEveryInstructionSet) {
  const Bvh built = build(mesh_, "lbvh > bvh8");
  const Bvh8& bvh = std::get<Bvh8>(built.layout);
  if (bvh.nodes.empty()) return;
  const FaceFilter filter{Cull::back, faces_.data()};
  for (const Isa isa : test::runnable_isas()) {
    WaveStacks stacks(bvh, rays_.size());
    std::vector<Hit> hits(rays_.size());
    const auto found = std::make_unique<bool[]>(rays_.size());
    const Bvh8View view(bvh, filter);
    const Bvh8Tracer tracer = filtered_bvh8_tracer(isa);
    tracer.closest(view, rays_.data(), rays_.size(), hits.data(), stacks.view());
    tracer.any(view, rays_.data(), rays_.size(), found.get(), stacks.view());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const Hit expected = expected_hit(filter, mesh_, rays_[i]);
      ASSERT_EQ(hits[i], expected) << "isa " << int(isa) << ", ray " << i;
      ASSERT_EQ(found[i], expected.is_hit()) << "isa " << int(isa) << ", ray " << i;
    }
  }
}

TEST_P(Filters, LeaveOutRaysThatAreNotActive) {
  const Bvh bvh = build(mesh_);
  RayBatch batch(rays_);
  std::vector<Hit> all = bvh.intersect(rays_), hits(rays_.size());
  batch.active = {active_.data(), 1};
  std::visit([&](const auto& tree) { intersect(tree, batch, std::span(hits)); }, bvh.layout);
  std::vector<Work> work(rays_.size());
  bvh.count_work(batch, work);
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    ASSERT_EQ(hits[i], active_[i] ? all[i] : Hit{}) << "ray " << i;
    if (!active_[i]) {
      ASSERT_EQ(work[i].nodes, 0u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(HardMeshes, Filters, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

}  // namespace
}  // namespace treelet
