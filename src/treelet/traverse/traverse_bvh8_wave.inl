// Rays, or packets of them, that are traced in turns. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

/// Packets in a wave.
constexpr std::uint32_t kWavePackets = 8;

/// Numbers of the rays of a wave that wait for the same kind of child. Once more than there are
/// rays: the place after the last is written in vain.
struct Queue {
  std::uint32_t rays[kWaveRays + 1];
  unsigned count = 0;
};

/// Where children of a kind lie: nodes, or blocks of leaves.
struct ChildKind {
  const char* first;
  std::uint32_t index_bits, size;

  TREELET_INLINE const char* at(WideChild child) const {
    return first + std::size_t(child.bits & index_bits) * size;
  }
};

/// Rays of a batch that are looked at together.
constexpr std::uint32_t kPartRays = 1024;

/// Numbers of some of them: of packets, that of the first ray.
struct RayNumbers {
  std::uint32_t rays[kPartRays];
  std::uint32_t count = 0;

  TREELET_INLINE void add(std::uint32_t first, std::uint32_t size) {
    for (std::uint32_t i = 0; i < size; ++i) rays[count++] = first + i;
  }
};

/// How many packets are not even tried after several that gave up one after the other.
class Pause {
 public:
  TREELET_INLINE void report(bool is_done) {
    left_ = is_done ? 0 : next_;
    next_ = is_done ? 0 : next_ < kLongest ? 2 * next_ + 1 : next_;
    has_failed_ = !is_done;
  }
  TREELET_INLINE bool has_failed() const { return has_failed_; }
  TREELET_INLINE bool is_over() {
    if (left_ == 0) return true;
    --left_;
    return false;
  }

 private:
  static constexpr std::uint32_t kLongest = 15;
  std::uint32_t next_ = 0, left_ = 0;
  bool has_failed_ = false;
};

/// Travellers through the tree, rays or packets of rays, in turns. In its turn one visits a child,
/// a node or the blocks of a leaf, and the next child is fetched until its next turn. No turn
/// depends on the one before, and one queue for nodes and one for leaves leave the processor
/// nothing to guess.
template <class Query, class Traveller, std::uint32_t count>
class Wave {
  using Answer = typename Query::Answer;

 public:
  /// Those that cannot be traced so are rejected.
  TREELET_INLINE Wave(const Bvh8View& bvh, const Ray* rays, const RayNumbers& numbers,
                      Answer* answers, RayNumbers& rejected)
      : bvh_(bvh),
        scene_(bvh.bounds),
        source_(rays),
        numbers_(numbers),
        answers_(answers),
        rejected_(rejected) {}

  TREELET_INLINE void run(const WaveStacks::View& stacks) {
    for (std::uint32_t i = 0; i < count && i < stacks.rays; ++i) {
      std::uint32_t* const memory = stacks.memory + 2 * i * stacks.stride;
      travellers_[i].stack = {reinterpret_cast<std::int32_t*>(memory), memory + stacks.stride};
      travellers_[i].stack.keys[0] = 0;
      travellers_[i].stack.children[0] = WideChild::kNone;
      start_next(i, nodes_.count);
    }
    while (nodes_.count + leaves_.count != 0) {
      visit_nodes();
      visit_leaves();
    }
  }

 private:
  TREELET_INLINE void visit_nodes() {
    const unsigned waiting = nodes_.count;
    unsigned nodes = 0, leaves = leaves_.count;
    for (unsigned k = 0; k < waiting; ++k) {
      const std::uint32_t i = nodes_.rays[k];
      Traveller& ray = travellers_[i];
      ray.count_node();
      const ChildStack top{ray.stack.keys + ray.size, ray.stack.children + ray.size};
      ray.size += push_children<!Query::kAny>(ray.slabs, bvh_.nodes[ray.child.node()], top);
      queue_next(i, nodes, leaves);
    }
    nodes_.count = nodes;
    leaves_.count = leaves;
  }

  TREELET_INLINE void visit_leaves() {
    const unsigned waiting = leaves_.count;
    unsigned nodes = nodes_.count, leaves = 0;
    for (unsigned k = 0; k < waiting; ++k) {
      const std::uint32_t i = leaves_.rays[k];
      Traveller& ray = travellers_[i];
      const TriangleBlock* const blocks = bvh_.blocks + ray.child.first_block();
      if (ray.visit_leaf(blocks, ray.child.block_count(), bvh_.filter)) ray.size = 1;
      queue_next(i, nodes, leaves);
    }
    nodes_.count = nodes;
    leaves_.count = leaves;
  }

  /// Pops the ray's next child, or ends the ray and starts another.
  TREELET_INLINE void queue_next(std::uint32_t i, unsigned& nodes, unsigned& leaves) {
    Traveller& ray = travellers_[i];
    const WideChild child{ray.stack.children[--ray.size]};
    if (child.is_none()) {
      pause_.report(ray.finish(answers_));
      if (pause_.has_failed()) rejected_.add(ray.number, 1);
      return start_next(i, nodes);
    }
    ray.child = child;
    const unsigned is_leaf = child.bits >> 31;
    const char* const memory = kinds_[is_leaf].at(child);
    for (unsigned offset = 0; offset < sizeof(Bvh8Node); offset += 64) {
      __builtin_prefetch(memory + offset);
    }
    leaves_.rays[leaves] = i;
    leaves += is_leaf;
    nodes_.rays[nodes] = i;
    nodes += 1 - is_leaf;
  }

  TREELET_INLINE void start_next(std::uint32_t i, unsigned& nodes) {
    Traveller& ray = travellers_[i];
    while (next_ != numbers_.count) {
      ray.number = numbers_.rays[next_++];
      if (pause_.is_over() && ray.set_up(source_ + ray.number, scene_, answers_ + ray.number)) {
        ray.child = WideChild::node(0);
        ray.size = 1;
        nodes_.rays[nodes++] = i;
        return;
      }
      rejected_.add(ray.number, 1);
    }
  }

  const Bvh8View& bvh_;
  const SceneLanes scene_;
  const ChildKind kinds_[2] = {
      {reinterpret_cast<const char*>(bvh_.nodes), ~WideChild::kLeafBit, sizeof(Bvh8Node)},
      {reinterpret_cast<const char*>(bvh_.blocks), WideChild::kMaxBlockIndex,
       sizeof(TriangleBlock)}};
  const Ray* const source_;
  const RayNumbers& numbers_;
  Answer* const answers_;
  std::uint32_t next_ = 0;
  Pause pause_;
  Queue nodes_, leaves_;
  RayNumbers& rejected_;
  Traveller travellers_[count];
};

}  // namespace
}  // namespace treelet::TREELET_ISA
