#include "station/render/still_painter.h"

#include "station/render/materials.h"

namespace enamel::station::render {

StillPainter::StillPainter(const Camera& camera, int side_px)
    : eye_{camera.ViewFromScene(), camera.ClipFromView(1), false, {0, 0, 0, 1}},
      side_px_(side_px) {}

std::shared_ptr<const Target> StillPainter::Paint(const GroupMesh& mesh, Colours colours) {
  programs_.kept.Use();
  colours == Colours::kTissues ? SetMaterials(programs_.kept)
                               : SetDeviationMaterials(programs_.kept);
  Body body;
  body.triangles.Upload(mesh.vertices, mesh.indices);
  body.bounds = BoundsOf(mesh.vertices, mesh.indices);
  const Body* const bodies[] = {&body};
  Quality quality = kQualities[1];
  quality.lighter_turning = false;
  ToothLayer layer(programs_);
  layer.Resize(side_px_, side_px_);
  layer.Draw(bodies, eye_, quality, PixelRect::Whole(side_px_, side_px_));
  auto still = std::make_shared<Target>(side_px_, side_px_, std::initializer_list<GLenum>{GL_RGBA8},
                                        false, GL_LINEAR);
  layer.composed().CopyColourTo(*still);
  return still;
}

}  // namespace enamel::station::render
