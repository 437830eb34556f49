#include "station/lab/pictures/kept_views.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "common/cutting/cutter.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/preparation.h"
#include "common/scene/tooth_number.h"
#include "station/desk/desk_attempt.h"
#include "station/desk/target_outline.h"
#include "station/mouth/mouth.h"
#include "station/render/tooth_view.h"

namespace enamel::station::lab {
namespace {

using render::Image;

// The default voxel of scenes (import, run).
constexpr int32_t kVoxel_nm = 50'000;
constexpr auto kLimit = std::chrono::minutes(2);
constexpr float kNotchesForMirror = 5;  // of the wheel, until all of it is in the picture
// The slot under the bur.
constexpr double kSlotLength_m = 2.5e-3, kSlotDepth_m = 0.8e-3, kStride_m = 20e-6;

// The tooth without its mesial half, or where it lies on its back without its left one; a lesion in
// its fossa is halved.
cutting::Volume CutOpen(const scene::BuiltScene& built) {
  constexpr int32_t kFar_um = 30'000;
  scene::Preparation half;
  half.parts.push_back({scene::PreparationPart::Outline::kBox,
                        {scene::MesialX(built.scene.tooth) * kFar_um, 0, 0},
                        {kFar_um, kFar_um},
                        kFar_um});
  return scene::Prepared(built.volume, half);
}

// What is drawn of a scene beside its exercises. Scenes of one tooth share what they have in common:
// their exercises are kept once.
struct SceneViews {
  std::string_view scene;
  bool mouth = true, open = true, bur = false, mirror = false;
  // Kept for an earlier scene: beginnings of exercises' names.
  std::vector<std::string_view> known = {};
};
const SceneViews& ViewsOf(std::string_view scene) {
  static const std::vector<SceneViews> all = {
      {.scene = "premolar", .mirror = true},
      {.scene = "molar-left",
       .mouth = false,
       .open = false,
       .known = {"class-1", "crown", "access"}},
      {.scene = "molar-caries-shallow", .mouth = false, .open = false},
      {.scene = "molar-caries-deep", .mouth = false, .open = false},
      {.scene = "molar-caries", .mouth = false, .bur = true, .known = {"class-1", "crown"}},
      {.scene = "molar-class-2", .mouth = false, .known = {"class-1", "crown"}},
      {.scene = "molar-buccal", .open = false},
      {.scene = "incisor-labial", .open = false, .bur = true},
      {.scene = "block", .open = false},
  };
  static const SceneViews plain;
  const auto found = std::ranges::find(all, scene, &SceneViews::scene);
  return found == all.end() ? plain : *found;
}

class Drawing {
 public:
  Drawing(const scene::BuiltScene& built, std::string name,
          const std::function<Status(const std::string&, const Image&)>& take)
      : built_(built), name_(std::move(name)), views_(ViewsOf(name_)), take_(take) {
    for (scene::Exercise& exercise : scene::BuiltinExercises(built.scene, Sha256{})) {
      const bool known = std::ranges::any_of(
          views_.known, [&](std::string_view begin) { return exercise.name.starts_with(begin); });
      if (!known) exercises_.push_back(std::move(exercise));
    }
  }

  Status Draw() const {
    ENAMEL_RETURN_IF_ERROR(DrawUncut());
    if (views_.open) ENAMEL_RETURN_IF_ERROR(DrawOpen());
    for (const scene::Exercise& exercise : exercises_) {
      const auto prepared = desk::PreparedFor(built_.scene, exercise.target, built_.volume);
      if (!prepared) continue;
      const auto view = See(*prepared, exercise, true);
      ENAMEL_RETURN_IF_ERROR(Take(*view, exercise.name + ".target"));
    }
    return views_.bur ? DrawBur() : Status::Ok();
  }

 private:
  using ToothView = render::ToothView;

  void Look(ToothView& view, const scene::Exercise& exercise, bool near) const {
    render::ViewOptions options = desk::ViewOf(built_.scene, exercise);
    options.aside = 0;
    if (!near) options.work_radius_m = 0;
    view.camera() = render::StillCamera(options, built_.volume);
  }

  // A view of `tooth` that looks at all of it, or near the exercise's place.
  std::unique_ptr<ToothView> See(const cutting::Volume& tooth, const scene::Exercise& exercise,
                                 bool near) const {
    auto view = std::make_unique<ToothView>(desk::ViewOf(built_.scene, exercise), tooth,
                                            render::VolumeWatch{}, &built_.volume);
    Look(*view, exercise, near);
    return view;
  }

  Status Take(ToothView& view, const std::string& name) const {
    if (!view.WaitIdle(kLimit)) {
      return Status(Code::kUnavailable, name + ": the tooth's surface was not ready in time");
    }
    view.Draw(kKeptWidth_px, kKeptHeight_px, render::kQualities[0]);
    return take_(name, render::ReadImage(view.result()));
  }

  Status DrawUncut() const {
    const bool tooth = scene::IsToothNumber(built_.scene.tooth);
    const auto view = See(built_.volume, exercises_.front(), false);
    if (views_.mouth || views_.mirror) {
      view->SetScenery(mouth::MakeMouth(built_.scene, built_.volume, {}));
    }
    if (views_.mouth) ENAMEL_RETURN_IF_ERROR(Take(*view, name_ + (tooth ? ".mouth" : ".whole")));
    if (views_.mirror) {
      Look(*view, exercises_.front(), true);
      view->mirror().Show(true, view->camera());
      view->camera().Zoom(-kNotchesForMirror);
      ENAMEL_RETURN_IF_ERROR(Take(*view, name_ + ".mirror"));
      view->mirror().Show(false, view->camera());
    }
    if (!tooth) return Status::Ok();
    view->ShowOutline(true);
    for (const scene::Exercise& exercise : exercises_) {
      const auto outline = desk::OutlineOf(built_.scene, exercise.target, built_.volume);
      view->SetOutline(outline);
      view->SetScenery(
          mouth::MakeMouth(built_.scene, built_.volume, outline, {exercise.isolation}));
      Look(*view, exercise, true);
      ENAMEL_RETURN_IF_ERROR(Take(*view, exercise.name + ".start"));
    }
    return Status::Ok();
  }

  Status DrawOpen() const {
    const auto view = See(CutOpen(built_), exercises_.front(), false);
    view->camera().SetView(render::View::kMesial);
    return Take(*view, name_ + ".open");
  }

  // Down into the place to cut and along it, with the bur upright.
  Status DrawBur() const {
    const scene::Exercise& exercise = exercises_.front();
    cutting::Volume volume = built_.volume;
    volume.Reserve();
    cutting::Cutter cutter(volume, exercise.bur().metric());
    cutting::RemovedUnits removed{};
    render::FrameState state;
    auto cut = [&](const dvec3& from, const dvec3& way) {
      const int steps = static_cast<int>(glm::length(way) / kStride_m);
      for (int i = 0; i <= steps; ++i) {
        state.anchor.tip_m = from + way * (static_cast<double>(i) / steps);
        cutter.Cut(state.anchor, removed);
      }
    };
    const dvec3 down(0, 0, -kSlotDepth_m), along(kSlotLength_m, 0, 0);
    const dvec3 begin = desk::ViewOf(built_.scene, exercise).work_m - 0.5 * along;
    cut(begin, down);
    cut(begin + down, along);
    const auto view = See(volume, exercise, true);
    state.device = state.anchor;
    state.pressed_n = {0.4, 0, 1.2};
    view->Publish(state);
    return Take(*view, name_ + ".bur");
  }

  const scene::BuiltScene& built_;
  const std::string name_;
  const SceneViews& views_;
  std::vector<scene::Exercise> exercises_;
  const std::function<Status(const std::string&, const Image&)>& take_;
};

}  // namespace

Status DrawKeptViews(std::string_view scene, const render::Screen&,
                     const std::function<Status(const std::string&, const Image&)>& take) {
  ENAMEL_ASSIGN_OR_RETURN(const auto built, scene::BuildBuiltinScene(scene, kVoxel_nm));
  return Drawing(built, std::string(scene), take).Draw();
}

}  // namespace enamel::station::lab
