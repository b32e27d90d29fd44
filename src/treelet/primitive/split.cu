#include <treelet/primitive/split.h>

#include <algorithm>

#include <treelet/primitive/split_steps.h>
#include <treelet/core/launch.cuh>
#include <treelet/primitive/device_references.cuh>

// As the host, but for two things. Instead of one candidate for the factor after another, a pass
// over the priorities tries all that the next five rounds of the search can come to, one a lane:
//
//     lane                     0                    a lane's candidate follows from what its
//                     fits  /     \  exceeds        ancestors' would have to find; one thread
//                       1            2              then walks down by what they did find
//                     /   \        /   \            and leaves the search where four passes
//                    3     4      5     6           make its twenty rounds
//
// And a thread a reference goes from its triangle's box down to its own piece. That repeats what
// the threads of its siblings do, but stores nothing on the way, and no triangle keeps one thread
// waiting. Counted for 20,000 triangles: of a soup, a reference added takes 2.0 splits instead of
// one at a budget of 30 percent, 2.8 at 300. Where a giant among tiny ones takes 33,552 of 60,000
// splits it is 9.6, but no thread makes more than 18.

namespace treelet::cuda {
namespace {

constexpr unsigned kThreads = 256;
constexpr unsigned kWarps = kThreads / kWarpSize;
/// Enough to fill the largest devices, few enough for one block to combine.
constexpr unsigned kMaxBlocks = 1024;
/// Threads of the one block that combines.
constexpr unsigned kCombiners = 1024;
constexpr unsigned kCombiningWarps = kCombiners / kWarpSize;

constexpr int kRoundsAPass = 5;
constexpr int kPasses = FactorSearch::kRounds / kRoundsAPass;
static_assert(kPasses * kRoundsAPass == FactorSearch::kRounds);
static_assert((1 << kRoundsAPass) == kWarpSize, "candidates of a pass, and a lane to spare");

constexpr float kLeftOut = -1.0f;

unsigned blocks_for(std::uint32_t faces) {
  return std::min(thread_each(faces, kThreads).blocks, kMaxBlocks);
}

/// What all kernels see.
struct Splitting {
  DeviceMesh mesh;
  SplitScratch scratch;
  DeviceScene* scene;
  Reference* references;
  std::uint32_t percent;
  unsigned blocks;  // that take part in sums

  __device__ ExactTriangle triangle(std::uint32_t face) const {
    return {triangle_of(mesh, face), power_of_two(-scene->scale_exponent)};
  }
};

__device__ float priority_of(const Splitting& s, std::uint32_t face) {
  const DeviceReferences whole{s.mesh, s.scene, nullptr, s.mesh.face_count};
  if (!takes_part(whole, face)) return kLeftOut;
  return split_priority(s.scene->grid, s.triangle(face), reference_of(whole, face).box());
}

/// For the whole block; its first warp gets the result.
template <unsigned Warps>
__device__ float block_maximum(float mine) {
  __shared__ float of_warp[Warps];
  const auto warp_maximum = [](float x) {
    for (int distance = kWarpSize / 2; distance > 0; distance /= 2) {
      x = max(x, __shfl_xor_sync(kFullWarp, x, distance));
    }
    return x;
  };
  mine = warp_maximum(mine);
  if (lane_index() == 0) of_warp[threadIdx.x / kWarpSize] = mine;
  __syncthreads();
  return warp_maximum(threadIdx.x < Warps ? of_warp[threadIdx.x] : 0.0f);
}

/// As on the host: a share of the regular triangles, as far as faces can be numbered.
__device__ std::uint64_t budget_of(const Splitting& s) {
  const std::uint64_t before = s.scene->reference_count;
  return std::min(before * s.percent / 100, kMaxFaces - before);
}

/// The search after the rounds that lead to a node of the tree of candidates; see above.
__device__ FactorSearch search_at(FactorSearch search, unsigned node) {
  constexpr std::uint64_t fits = 0, exceeds = ~std::uint64_t{0};
  const unsigned path = node + 1;  // below its highest bit, a bit for each round
  for (int bit = 30 - __clz(int(path)); bit >= 0; --bit) {
    search.learn((path >> bit & 1) == 0 ? fits : exceeds);
  }
  return search;
}

/// Splits among a warp's share of the faces, for this lane's candidate.
__device__ std::uint64_t count_share(const Splitting& s, std::uint64_t warp) {
  const float candidate = search_at(*s.scratch.search, lane_index()).candidate();
  const std::uint64_t faces = s.mesh.face_count, warps = s.blocks * kWarps;
  const auto end = std::uint32_t(faces * (warp + 1) / warps);
  std::uint64_t splits = 0;
  for (auto face = std::uint32_t(faces * warp / warps); face < end; ++face) {
    splits += split_count(candidate, max(s.scratch.priorities[face], 0.0f));
  }
  return splits;
}

/// Sums of a column a lane, over the block's warps; the first warp gets the result.
template <unsigned Warps>
__device__ std::uint64_t sum_columns(std::uint64_t mine) {
  __shared__ std::uint64_t of_warp[Warps][kWarpSize];
  of_warp[threadIdx.x / kWarpSize][lane_index()] = mine;
  __syncthreads();
  std::uint64_t sum = 0;
  for (unsigned warp = 0; warp < Warps; ++warp) sum += of_warp[warp][lane_index()];
  return sum;
}

/// What the blocks have found for this lane's candidate, or with other warps' shares of it.
__device__ std::uint64_t sum_blocks(const Splitting& s) {
  std::uint64_t splits = 0;
  for (unsigned block = threadIdx.x / kWarpSize; block < s.blocks; block += kCombiningWarps) {
    splits += s.scratch.splits[block * kWarpSize + lane_index()];
  }
  return sum_columns<kCombiningWarps>(splits);
}

/// For a warp, whose lanes hold the splits of their candidates.
__device__ void advance(FactorSearch& search, std::uint64_t splits) {
  int node = 0;
  for (int round = 0; round < kRoundsAPass; ++round) {
    const std::uint64_t found = __shfl_sync(kFullWarp, splits, node);
    search.learn(found);
    node = 2 * node + (found <= search.budget ? 1 : 2);
  }
}

/// References of a face.
__device__ std::uint32_t references_of(const Splitting& s, std::uint32_t face) {
  const float priority = s.scratch.priorities[face];
  return priority < 0.0f ? 0 : split_count(s.scratch.search->factor(), priority) + 1;
}

/// The last of faces [first, last] whose references begin at a place or before; the first one's do.
__device__ std::uint32_t find_face(const std::uint32_t* offsets, std::uint32_t first,
                                   std::uint32_t last, std::uint32_t place) {
  while (first < last) {
    const std::uint32_t middle = last - (last - first) / 2;
    if (offsets[middle] <= place) {
      first = middle;
    } else {
      last = middle - 1;
    }
  }
  return first;
}

__device__ void write_reference(const Splitting& s, std::uint32_t face, std::uint32_t place) {
  const std::uint32_t first = s.scratch.offsets[face], end = s.scratch.offsets[face + 1];
  const Aabb box = find_piece(s.scene->grid, s.triangle(face), end - first - 1, place - first);
  s.references[place] = {box.lower, face, box.upper, 0};
}

/// For a whole block and the places of its threads. Two of them look among all faces, the others
/// between what those have found.
__device__ void write_block(const Splitting& s, std::uint32_t count) {
  __shared__ std::uint32_t face[2];
  const std::uint32_t first = blockIdx.x * kThreads, last = std::min(first + kThreads, count) - 1;
  const std::uint32_t* offsets = s.scratch.offsets;
  if (threadIdx.x < 2) {
    face[threadIdx.x] =
        find_face(offsets, 0, s.mesh.face_count - 1, threadIdx.x == 0 ? first : last);
  }
  __syncthreads();
  const std::uint32_t place = first + threadIdx.x;
  if (place <= last) write_reference(s, find_face(offsets, face[0], face[1], place), place);
}

__global__ void __launch_bounds__(kThreads) compute_priorities(Splitting s) {
  float largest = 0.0f;
  for (std::uint32_t face = thread_index(); face < s.mesh.face_count; face += s.blocks * kThreads) {
    const float priority = priority_of(s, face);
    s.scratch.priorities[face] = priority;
    largest = max(largest, priority);
  }
  largest = block_maximum<kWarps>(largest);
  if (threadIdx.x == 0) s.scratch.largest[blockIdx.x] = largest;
}

__global__ void __launch_bounds__(kCombiners) start_search(Splitting s) {
  static_assert(kMaxBlocks <= kCombiners);
  const float mine = threadIdx.x < s.blocks ? s.scratch.largest[threadIdx.x] : 0.0f;
  const float largest = block_maximum<kCombiningWarps>(mine);
  if (threadIdx.x == 0) *s.scratch.search = FactorSearch(largest, budget_of(s));
}

__global__ void __launch_bounds__(kThreads) count_splits(Splitting s) {
  const std::uint64_t splits = sum_columns<kWarps>(count_share(s, warp_index()));
  if (threadIdx.x >= kWarpSize) return;
  s.scratch.splits[blockIdx.x * kWarpSize + threadIdx.x] = splits;
}

__global__ void __launch_bounds__(kCombiners) advance_search(Splitting s) {
  FactorSearch search = *s.scratch.search;
  const std::uint64_t splits = sum_blocks(s);
  if (threadIdx.x >= kWarpSize) return;
  advance(search, splits);
  if (threadIdx.x == 0) *s.scratch.search = search;
}

/// Their sums are to be the offsets, and the total.
__global__ void count_references(Splitting s) {
  const std::uint32_t face = thread_index();
  if (face > s.mesh.face_count) return;
  s.scratch.offsets[face] = face < s.mesh.face_count ? references_of(s, face) : 0;
}

__global__ void __launch_bounds__(kThreads) write_references(Splitting s) {
  const std::uint32_t count = s.scratch.offsets[s.mesh.face_count];
  if (thread_index() == 0) s.scene->reference_count = count;
  if (blockIdx.x * kThreads < count) write_block(s, count);
}

void find_factor(const Splitting& s, Stream stream) {
  launch(stream, {1, kCombiners}, start_search, s);
  for (int pass = 0; pass < kPasses; ++pass) {
    launch(stream, {s.blocks, kThreads}, count_splits, s);
    launch(stream, {1, kCombiners}, advance_search, s);
  }
}

}  // namespace

std::uint32_t split_capacity(std::uint32_t faces, std::uint32_t percent) {
  const std::uint64_t budget = std::uint64_t{faces} * percent / 100;
  return std::uint32_t(std::min<std::uint64_t>(faces + budget, kMaxFaces));
}

SplitScratch carve_split_scratch(Carver& carver, std::uint32_t faces) {
  const std::size_t blocks = blocks_for(faces), offsets = std::size_t(faces) + 1;
  return {carver.take<float>(faces),
          carver.take<float>(blocks),
          carver.take<std::uint64_t>(blocks * kWarpSize),
          carver.take<FactorSearch>(1),
          carver.take<std::uint32_t>(offsets),
          carve_sum_scratch(carver, std::uint32_t(offsets))};
}

void split_references(const DeviceMesh& mesh, std::uint32_t percent, const SplitScratch& scratch,
                      DeviceScene* scene, Reference* references, Stream stream) {
  const std::uint32_t faces = mesh.face_count;
  if (faces == 0) return;
  const Splitting s{mesh, scratch, scene, references, percent, blocks_for(faces)};
  launch(stream, {s.blocks, kThreads}, compute_priorities, s);
  find_factor(s, stream);
  launch(stream, thread_each(std::size_t(faces) + 1), count_references, s);
  sum_before(scratch.offsets, scratch.offsets, faces + 1, scratch.sum, stream);
  launch(stream, thread_each(split_capacity(faces, percent), kThreads), write_references, s);
}

}  // namespace treelet::cuda
