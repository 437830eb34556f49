#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/triangles.h"

namespace enamel::import {

// Collects vertices and faces in the order of the file, and makes triangles of them at the end, since faces may come
// before their vertices. Bounded by mesh::kMaxTriangles and kMaxVertices.
class MeshBuilder {
 public:
  // A coordinate may be NaN or infinite: triangles with such a corner are left out and counted.
  Status AddVertex(const dvec3& at);
  size_t vertices() const { return out_.mesh.vertices.size(); }
  // Faces from now on belong to a part of this name and material.
  void StartPart(std::string_view name, std::string_view material);
  void AddCorner(uint64_t vertex) { corners_.push_back(vertex); }
  // Of AddCorner since the face before. Fewer than three corners are a point or a line: left out.
  Status EndFace();
  // What people should know: one sentence.
  void Note(std::string sentence);

  // Errors: kInvalidInput where a face names a vertex that is not there, a coordinate is beyond what
  // a tooth can have, or there are no triangles.
  Result<mesh::NamedMesh> Finish();

 private:
  struct Part {
    std::string name, material;
    size_t first_face;
  };
  Status CheckCoordinates() const;
  void AddFace(const uint64_t* corners, size_t count);

  mesh::NamedMesh out_;
  std::vector<uint64_t> corners_;  // of all faces
  std::vector<size_t> face_ends_;  // into corners_
  std::vector<Part> parts_;
  size_t triangles_ = 0, without_place_ = 0;
};

}  // namespace enamel::import
