#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "station/render/mesher.h"

namespace enamel::station::render {

// What is drawn around a tooth and never changes: made once, on any thread. Scene frame. GroupMesh's
// `group` is not used.
struct Scenery {
  std::vector<GroupMesh> fixed;
  // Each of these is left out while it would stand between the viewer and a point of the work.
  std::vector<GroupMesh> giving_way;
  // The same, but together: all of these are left out while one of them is in the way.
  std::vector<GroupMesh> opposite;
  std::vector<glm::vec3> work_mm;
  // Of the tooth only what reaches where dot(hides_below, (p, 1)) >= 0 is drawn: the rest is under
  // the scenery.
  glm::vec4 hides_below{0};

  bool empty() const { return fixed.empty() && giving_way.empty() && opposite.empty(); }
  size_t triangle_count() const;
  size_t bytes() const;  // on the graphics card
};

struct Box {
  glm::vec3 lo_mm{0}, hi_mm{0};
};
std::vector<Box> BoxesOf(std::span<const GroupMesh> meshes);
// Whether the straight way from a point to the eye meets the box.
bool Covers(const Box& box, const glm::vec3& point_mm, const glm::vec3& eye_mm);

}  // namespace enamel::station::render
