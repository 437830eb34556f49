#include "common/import/mesh_builder.h"

#include <algorithm>
#include <cmath>

#include "common/import/printable.h"

namespace enamel::import {
namespace {

// Finding the ears of a polygon takes time with the cube of its corners.
constexpr size_t kMaxEars = 64;

Status Invalid(const std::string& what) { return Status(Code::kInvalidInput, what); }

Status TooMany() {
  return Status(Code::kTooLarge, "more than " + std::to_string(mesh::kMaxTriangles) +
                                     " triangles: reduce the mesh in a mesh program (a crown "
                                     "needs no more than 200000)");
}

bool IsPlace(const dvec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// Cuts one triangle off a polygon's outline, `corners`: the first that turns the way the polygon
// does and holds no other corner; where none does (a polygon that crosses itself), any.
size_t FindEar(const std::vector<dvec3>& at, const std::vector<uint32_t>& corners,
               const dvec3& facing) {
  const size_t n = corners.size();
  auto side = [&](const dvec3& a, const dvec3& b, const dvec3& p) {
    return Dot(glm::cross(b - a, p - a), facing);
  };
  for (size_t i = 0; i < n; ++i) {
    const dvec3 &a = at[corners[(i + n - 1) % n]], &b = at[corners[i]],
                &c = at[corners[(i + 1) % n]];
    if (!(side(a, b, c) > 0)) continue;
    const bool holds = std::any_of(corners.begin(), corners.end(), [&](uint32_t v) {
      const dvec3& p = at[v];
      return p != a && p != b && p != c && side(a, b, p) >= 0 && side(b, c, p) >= 0 &&
             side(c, a, p) >= 0;
    });
    if (!holds) return i;
  }
  return n - 1;
}

}  // namespace

Status MeshBuilder::AddVertex(const dvec3& at) {
  if (out_.mesh.vertices.size() >= mesh::kMaxVertices) return TooMany();
  out_.mesh.vertices.push_back(at);
  return Status::Ok();
}

void MeshBuilder::StartPart(std::string_view name, std::string_view material) {
  auto text = [](std::string_view from) {
    return Printable(std::string(from.substr(0, mesh::kMaxPartName)));
  };
  const Part part{text(name), text(material), face_ends_.size()};
  if (!parts_.empty() && parts_.back().first_face == face_ends_.size()) parts_.pop_back();
  if (parts_.size() < mesh::kMaxParts) parts_.push_back(part);
}

Status MeshBuilder::EndFace() {
  const size_t first = face_ends_.empty() ? 0 : face_ends_.back();
  const size_t count = corners_.size() - first;
  if (count < 3) {
    corners_.resize(first);
    return Status::Ok();
  }
  triangles_ += count - 2;
  if (triangles_ > mesh::kMaxTriangles) return TooMany();
  if (parts_.empty()) StartPart({}, {});
  face_ends_.push_back(corners_.size());
  return Status::Ok();
}

void MeshBuilder::Note(std::string sentence) {
  if (out_.notes.size() < mesh::kMaxNotes) out_.notes.push_back(Printable(std::move(sentence)));
}

Status MeshBuilder::CheckCoordinates() const {
  constexpr double kFarthest = 1e9;  // a kilometre in micrometres
  for (size_t i = 0; i < out_.mesh.vertices.size(); ++i) {
    const dvec3& v = out_.mesh.vertices[i];
    if (!IsPlace(v)) continue;
    if (std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}) > kFarthest)
      return Invalid("vertex " + std::to_string(i) +
                     " has a coordinate beyond 1000000000: the file is damaged, export it again");
  }
  return Status::Ok();
}

void MeshBuilder::AddFace(const uint64_t* corners, size_t count) {
  const std::vector<dvec3>& at = out_.mesh.vertices;
  std::vector<uint32_t> left;
  left.reserve(count);
  for (size_t i = 0; i < count; ++i) left.push_back(static_cast<uint32_t>(corners[i]));
  if (std::any_of(left.begin(), left.end(), [&](uint32_t v) { return !IsPlace(at[v]); })) {
    without_place_ += count - 2;
    return;
  }
  std::vector<std::array<uint32_t, 3>>& triangles = out_.mesh.indices;
  if (count > 3 && count <= kMaxEars) {
    dvec3 facing(0);
    for (size_t i = 1; i + 1 < count; ++i)
      facing += glm::cross(at[left[i]] - at[left[0]], at[left[i + 1]] - at[left[0]]);
    while (left.size() > 3) {
      const size_t n = left.size(), ear = FindEar(at, left, facing);
      triangles.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
      left.erase(left.begin() + static_cast<ptrdiff_t>(ear));
    }
  }
  for (size_t i = 1; i + 1 < left.size(); ++i) triangles.push_back({left[0], left[i], left[i + 1]});
}

Result<mesh::NamedMesh> MeshBuilder::Finish() {
  ENAMEL_RETURN_IF_ERROR(CheckCoordinates());
  const size_t n = out_.mesh.vertices.size();
  for (uint64_t corner : corners_) {
    if (corner < n) continue;
    return Invalid("a face names vertex " + std::to_string(corner) + " of " + std::to_string(n) +
                   ", counted from 0: export the file again");
  }
  out_.mesh.indices.reserve(triangles_);
  for (size_t part = 0; part < parts_.size(); ++part) {
    const size_t end = part + 1 < parts_.size() ? parts_[part + 1].first_face : face_ends_.size();
    const auto first = static_cast<uint32_t>(out_.mesh.indices.size());
    for (size_t face = parts_[part].first_face; face < end; ++face) {
      const size_t begin = face == 0 ? 0 : face_ends_[face - 1];
      AddFace(&corners_[begin], face_ends_[face] - begin);
    }
    const auto count = static_cast<uint32_t>(out_.mesh.indices.size()) - first;
    if (count > 0) out_.parts.push_back({parts_[part].name, parts_[part].material, first, count});
  }
  if (without_place_ > 0) {
    Note(std::to_string(without_place_) + " of " + std::to_string(triangles_) +
         " triangles left out: a corner has a coordinate that is not a finite number");
  }
  if (out_.mesh.indices.empty()) {
    return Invalid(without_place_ > 0
                       ? "none of its " + std::to_string(triangles_) +
                             " triangles has coordinates that are finite numbers: export it again"
                       : "holds no triangles, only points or nothing");
  }
  // Vertices without a place are named by no triangle any more.
  for (dvec3& v : out_.mesh.vertices) {
    if (!IsPlace(v)) v = out_.mesh.vertices[out_.mesh.indices[0][0]];
  }
  return std::move(out_);
}

}  // namespace enamel::import
