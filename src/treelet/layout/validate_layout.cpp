#include <treelet/layout/validate_bvh2.h>

#include <treelet/tree/violations.h>

namespace treelet {
namespace {

std::string name(std::uint32_t node, int child) {
  return "child " + std::to_string(child) + " of node " + std::to_string(node);
}

/// Checks the tree itself.
class TreeValidator {
 public:
  TreeValidator(const Bvh2& bvh, Violations& violations)
      : bvh_(bvh), violations_(violations), triangle_seen_(bvh.triangles.size(), false) {}

  void run() {
    if (!bvh_.nodes.empty()) walk();
    if (!violations_.full() && nodes_seen_ != bvh_.nodes.size()) {
      violations_.add(std::to_string(bvh_.nodes.size() - nodes_seen_) + " nodes are unreachable");
    }
    check_all_triangles_seen();
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
      if (visit.node != nodes_seen_++) {
        violations_.add("node " + std::to_string(visit.node) + " is out of depth-first order");
        return;
      }
      if (visit.depth > bvh_.depth) violations_.add("the tree is deeper than its depth says");
      check_children(visit, stack);
    }
  }

  void check_children(const Visit& visit, std::vector<Visit>& stack) {
    const Bvh2Node& node = bvh_.nodes[visit.node];
    for (const int child : {1, 0}) {
      if (!visit.box.contains(node.box[child])) {
        violations_.add(name(visit.node, child) + " sticks out of its parent's box");
      }
      if (node.is_leaf(child)) {
        check_leaf(visit.node, child);
      } else if (!node.box[child].is_empty()) {
        if (node.index[child] >= bvh_.nodes.size()) {
          violations_.add(name(visit.node, child) + " does not exist");
        } else {
          stack.push_back({node.index[child], node.box[child], visit.depth + 1});
        }
      }
    }
  }

  void check_leaf(std::uint32_t index, int child) {
    const Bvh2Node& node = bvh_.nodes[index];
    const std::size_t end = std::size_t(node.index[child]) + node.count[child];
    if (end > bvh_.triangles.size()) {
      return violations_.add(name(index, child) + " has triangles that do not exist");
    }
    for (std::size_t i = node.index[child]; i < end; ++i) {
      const PackedTriangle& packed = bvh_.triangles[i];
      if (!node.box[child].contains(bounds(packed.triangle()))) {
        violations_.add(name(index, child) + " does not contain its triangle " + std::to_string(i));
      }
      if (triangle_seen_[i]) {
        violations_.add("triangle " + std::to_string(i) + " is in two leaves");
      }
      triangle_seen_[i] = true;
    }
  }

  void check_all_triangles_seen() {
    for (std::size_t i = 0; i < triangle_seen_.size() && !violations_.full(); ++i) {
      if (!triangle_seen_[i]) violations_.add("triangle " + std::to_string(i) + " is in no leaf");
    }
  }

  const Bvh2& bvh_;
  Violations& violations_;
  std::vector<bool> triangle_seen_;
  std::size_t nodes_seen_ = 0;
};

/// Compares the tree's triangles with the mesh's.
class MeshComparison {
 public:
  MeshComparison(const Bvh2& bvh, const Mesh& mesh, Violations& violations)
      : bvh_(bvh), mesh_(mesh), violations_(violations), face_seen_(mesh.faces.size(), false) {}

  void run() {
    for (std::size_t i = 0; i < bvh_.triangles.size() && !violations_.full(); ++i) {
      check_triangle(bvh_.triangles[i], i);
    }
    check_all_faces_seen();
  }

 private:
  void check_triangle(const PackedTriangle& packed, std::size_t i) {
    if (packed.face >= mesh_.faces.size()) {
      return violations_.add("triangle " + std::to_string(i) + " is of no face of the mesh");
    }
    face_seen_[packed.face] = true;
    const Triangle expected = mesh_.triangle(packed.face);
    if (packed.p0 != expected.p0 || packed.p1 != expected.p1 || packed.p2 != expected.p2) {
      violations_.add("triangle " + std::to_string(i) + " differs from face " +
                      std::to_string(packed.face));
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

  const Bvh2& bvh_;
  const Mesh& mesh_;
  Violations& violations_;
  std::vector<bool> face_seen_;
};

}  // namespace

std::vector<std::string> validate(const Bvh2& bvh) {
  Violations violations;
  TreeValidator(bvh, violations).run();
  return violations.take();
}

std::vector<std::string> validate(const Bvh2& bvh, const Mesh& mesh) {
  Violations violations;
  TreeValidator(bvh, violations).run();
  MeshComparison(bvh, mesh, violations).run();
  return violations.take();
}

}  // namespace treelet
