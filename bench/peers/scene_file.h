#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <treelet/mesh/mesh.h>
#include <treelet/query/ray_batch.h>

namespace treelet::peers {

/// Rays of one kind, saved so that all trace the same.
struct RaySet {
  std::string kind;  ///< "primary", "diffuse", "ambient_occlusion"
  bool any_hit = false;
  std::vector<Vec3> origins, directions;
  std::vector<float> t_max;

  RayBatch batch() const;
};

/// A mesh and rays through it. Written by scene_file.py, which says how.
struct SceneFile {
  std::vector<Vec3> vertices;
  std::vector<Face> faces;
  std::vector<RaySet> ray_sets;

  Mesh mesh() const { return {vertices, faces}; }
};

/// Throws std::runtime_error, with the path, for a file that cannot be read or is none.
SceneFile read_scene_file(const std::filesystem::path& path);

}  // namespace treelet::peers
