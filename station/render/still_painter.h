#pragma once

#include <memory>

#include "station/render/camera.h"
#include "station/render/tooth_layer.h"

namespace enamel::station::render {

// Draws whole surfaces once each, as square pictures from one side. Needs the context current.
class StillPainter {
 public:
  enum class Colours { kTissues, kDeviation };  // what the vertices' materials mean

  // Throws std::runtime_error when the driver refuses a resource.
  StillPainter(const Camera& camera, int side_px);

  // Destroy it while the context is current. Throws as the constructor.
  std::shared_ptr<const Target> Paint(const GroupMesh& mesh, Colours colours);

 private:
  const Eye eye_;
  const int side_px_;
  const ToothLayer::Programs programs_;
};

}  // namespace enamel::station::render
