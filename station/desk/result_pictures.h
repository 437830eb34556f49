#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "station/render/still_painter.h"
#include "station/render/tooth_view.h"
#include "station/session/look_back.h"

namespace enamel::station::desk {

// The tooth of an attempt: as it began, as it ended, as it was to become, and how far its end is from
// the reference.
struct ResultSurfaces {
  render::Camera camera{glm::vec3(0), 1};  // that all are seen with
  render::GroupMesh before, after;
  // Of `after`, to colour it once more; and the cells of its vertices.
  surface::Mesh after_surface;
  std::vector<ivec3> after_cells;
};
// Computes the recording to its end. Errors: LookBack::Take's. Thread safety: any thread.
Result<ResultSurfaces> SurfacesOf(LookBack& recording,
                                  const std::function<bool(double progress)>& keep_going);

// Of PreparedFor; empty where the exercise's target is none.
render::GroupMesh TargetSurface(const PreparedAttempt& prepared);
// The end's surface, whose vertices are of these cells, in the colours of a deviation
// (common/timeline/deviation.h). Errors:
// DecodeDeviation's.
Result<render::GroupMesh> DeviationSurface(const surface::Mesh& after, std::span<const ivec3> cells,
                                           ByteView deviation);

// The pictures of them, drawn as they come. Needs the context current. Owner's thread only.
class ResultPictures {
 public:
  explicit ResultPictures(const ResultSurfaces& surfaces);
  void Add(const render::GroupMesh& target, const std::optional<render::GroupMesh>& deviation);

  using Still = std::shared_ptr<const render::Target>;
  // Null: there is none.
  Still before, after, target, deviation;

 private:
  render::StillPainter painter_;
};

}  // namespace enamel::station::desk
