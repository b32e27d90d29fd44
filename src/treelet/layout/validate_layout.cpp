#include <treelet/layout/validate_layout.h>

#include <type_traits>

#include <treelet/layout/child_view.h>
#include <treelet/layout/cover.h>
#include <treelet/layout/cwbvh_meta.h>
#include <treelet/layout/face_positions.h>
#include <treelet/primitive/split_steps.h>
#include <treelet/tree/violations.h>

namespace treelet {
namespace {

std::string name(std::uint32_t node, int child) {
  return "child " + std::to_string(child) + " of node " + std::to_string(node);
}

/// Checks the tree itself.
template <class Layout>
class TreeValidator {
 public:
  TreeValidator(const Layout& bvh, Violations& violations)
      : bvh_(bvh),
        violations_(violations),
        faces_(bvh),
        triangle_seen_(position_count(bvh), false) {
    find_pieces();
  }

  void run() {
    if (!bvh_.nodes.empty()) walk();
    if (!violations_.full() && nodes_seen_ != bvh_.nodes.size()) {
      violations_.add(std::to_string(bvh_.nodes.size() - nodes_seen_) + " nodes are unreachable");
    }
    check_all_triangles_seen();
    check_pieces_cover();
  }

 private:
  struct Visit {
    std::uint32_t node;
    Aabb box;
    std::uint32_t depth;
  };

  void walk() {
    std::vector<Visit> stack{{0, bvh_.bounds, 1}};
    while (!stack.empty() && !violations_.full()) {
      const Visit visit = stack.back();
      stack.pop_back();
      const bool in_order = is_in_order(bvh_, visit.node);
      ++nodes_seen_;
      if (!in_order) {
        violations_.add("node " + std::to_string(visit.node) + " is out of depth-first order");
        return;
      }
      if (visit.depth > bvh_.depth) violations_.add("the tree is deeper than its depth says");
      check_children(visit, stack);
    }
  }

  template <class AnyLayout>
  bool is_in_order(const AnyLayout&, std::uint32_t node) const {
    return node == nodes_seen_;
  }

  /// A node's children and the triangles of its leaves come where those of all before it end.
  bool is_in_order(const Cwbvh& bvh, std::uint32_t index) {
    const CwbvhNode& node = bvh.nodes[index];
    const bool in_order = node.first_node == next_node_ && node.first_triangle == next_triangle_;
    for (int i = 0; i < CwbvhNode::kChildren; ++i) {
      next_node_ += node.is_node(i);
      next_triangle_ += node.is_leaf(i) ? node.triangle_count(i) : 0;
      if (!has_sound_meta(node, i)) {
        violations_.add(name(index, i) + " is neither a node nor a leaf");
      }
    }
    return in_order;
  }

  /// What of a child's box rays can reach.
  template <class AnyLayout>
  Aabb reachable_box(const AnyLayout&, const Visit& visit, int i, const Aabb& box) {
    if (!visit.box.contains(box)) {
      violations_.add(name(visit.node, i) + " sticks out of its parent's box");
    }
    return box;
  }
  Aabb reachable_box(const Cwbvh&, const Visit& visit, int, const Aabb& box) {
    return overlap(box, visit.box);
  }

  void check_children(const Visit& visit, std::vector<Visit>& stack) {
    for (int i = children_per_node(bvh_); i-- > 0;) {
      ChildView child = child_of(bvh_, visit.node, i);
      child.box = reachable_box(bvh_, visit, i, child.box);
      if (child.is_leaf) {
        check_leaf(child, name(visit.node, i));
      } else if (!child.box.is_empty()) {
        if (child.node >= bvh_.nodes.size()) {
          violations_.add(name(visit.node, i) + " does not exist");
        } else {
          stack.push_back({child.node, child.box, visit.depth + 1});
        }
      }
    }
  }

  void check_leaf(const ChildView& leaf, const std::string& leaf_name) {
    if (leaf.end > triangle_seen_.size()) {
      return violations_.add(leaf_name + " has triangles that do not exist");
    }
    Aabb whole = Aabb::empty();
    bool has_pieces = false;
    for (std::size_t i = leaf.begin; i < leaf.end; ++i) {
      const Aabb box = bounds(triangle_at(bvh_, i));
      whole = merge(whole, box);
      if (is_piece(i)) {
        has_pieces = true;
        leaf_boxes_[i] = leaf.box;
      } else if (has_triangle(bvh_, i) && !leaf.box.contains(box)) {
        violations_.add(leaf_name + " does not contain its triangle " + std::to_string(i));
      }
      if (triangle_seen_[i]) {
        violations_.add("triangle " + std::to_string(i) + " is in two leaves");
      }
      triangle_seen_[i] = true;
    }
    if (has_pieces && !whole.contains(leaf.box) && !std::is_same_v<Layout, Cwbvh>) {
      violations_.add(leaf_name + " is larger than its triangles");
    }
  }

  bool is_piece(std::size_t position) const { return !leaf_boxes_.empty() && is_piece_[position]; }

  /// A face at several positions was split; the unsplit tree gets no table of pieces.
  void find_pieces() {
    if (faces_.entry_count() == faces_.face_count()) return;
    is_piece_.resize(position_count(bvh_), false);
    leaf_boxes_.resize(position_count(bvh_), Aabb::empty());
    for (std::size_t rank = 0; rank < faces_.face_count(); ++rank) {
      const auto positions = faces_.of_rank(rank);
      for (const SortEntry& entry : positions) is_piece_[entry.value] = positions.size() > 1;
    }
  }

  void check_pieces_cover() {
    std::vector<Aabb> boxes;
    for (std::size_t rank = 0; rank < faces_.face_count() && !leaf_boxes_.empty(); ++rank) {
      const auto positions = faces_.of_rank(rank);
      if (positions.size() == 1) continue;
      boxes.clear();
      for (const SortEntry& entry : positions) boxes.push_back(leaf_boxes_[entry.value]);
      if (!covers(boxes, triangle_at(bvh_, positions.front().value))) {
        violations_.add("the leaves of face " + std::to_string(positions.front().key) +
                        " do not cover it");
      }
    }
  }

  void check_all_triangles_seen() {
    for (std::size_t i = 0; i < triangle_seen_.size() && !violations_.full(); ++i) {
      if (!triangle_seen_[i]) violations_.add("triangle " + std::to_string(i) + " is in no leaf");
    }
  }

  const Layout& bvh_;
  Violations& violations_;
  const FacePositions faces_;
  std::vector<bool> triangle_seen_;
  std::vector<bool> is_piece_;    // by position; empty where no face was split
  std::vector<Aabb> leaf_boxes_;  // by position, of pieces
  std::size_t nodes_seen_ = 0;
  std::size_t next_node_ = 1, next_triangle_ = 0;  // of a cwbvh: where the next ones belong
};

/// Compares the tree's triangles with the mesh's.
template <class Layout>
class MeshComparison {
 public:
  MeshComparison(const Layout& bvh, const Mesh& mesh, Violations& violations)
      : bvh_(bvh), mesh_(mesh), violations_(violations), face_seen_(mesh.faces.size(), false) {}

  void run() {
    for (std::size_t i = 0; i < position_count(bvh_) && !violations_.full(); ++i) {
      if (has_triangle(bvh_, i)) check_triangle(i);
    }
    check_all_faces_seen();
  }

 private:
  void check_triangle(std::size_t i) {
    const std::uint32_t face = face_at(bvh_, i);
    if (face >= mesh_.faces.size()) {
      return violations_.add("triangle " + std::to_string(i) + " is of no face of the mesh");
    }
    face_seen_[face] = true;
    if (triangle_at(bvh_, i) != mesh_.triangle(face)) {
      violations_.add("triangle " + std::to_string(i) + " differs from face " +
                      std::to_string(face));
    }
  }

  void check_all_faces_seen() {
    for (std::size_t face = 0; face < mesh_.faces.size() && !violations_.full(); ++face) {
      const bool expected = classify(mesh_.triangle(face)) == TriangleKind::regular;
      if (expected && !face_seen_[face]) {
        violations_.add("face " + std::to_string(face) + " is in no leaf");
      } else if (!expected && face_seen_[face]) {
        violations_.add("face " + std::to_string(face) + " should have been left out");
      }
    }
  }

  const Layout& bvh_;
  const Mesh& mesh_;
  Violations& violations_;
  std::vector<bool> face_seen_;
};

template <class Layout>
std::vector<std::string> validate_tree(const Layout& bvh, const Mesh* mesh) {
  Violations violations;
  TreeValidator<Layout>(bvh, violations).run();
  if (mesh != nullptr) MeshComparison<Layout>(bvh, *mesh, violations).run();
  return violations.take();
}

}  // namespace

std::vector<std::string> validate(const Bvh2& bvh) { return validate_tree(bvh, nullptr); }
std::vector<std::string> validate(const Bvh8& bvh) { return validate_tree(bvh, nullptr); }
std::vector<std::string> validate(const Cwbvh& bvh) { return validate_tree(bvh, nullptr); }
std::vector<std::string> validate(const Bvh2& bvh, const Mesh& mesh) {
  return validate_tree(bvh, &mesh);
}
std::vector<std::string> validate(const Bvh8& bvh, const Mesh& mesh) {
  return validate_tree(bvh, &mesh);
}
std::vector<std::string> validate(const Cwbvh& bvh, const Mesh& mesh) {
  return validate_tree(bvh, &mesh);
}

}  // namespace treelet
