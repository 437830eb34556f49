#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "common/cutting/cutter.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/builtin/teeth.h"
#include "common/scene/preparation.h"
#include "station/render/png_file.h"
#include "station/render/window.h"
#include "tests/station/render/virtual_display.h"

// Draws the built-in teeth before and after a class I, a class II and a crown preparation, and the
// practice block, with the station's own renderer: tooth_pictures FOLDER [voxel_um]
// The preparations are cut by the station's own cutter along paths of bur poses.

namespace {

using namespace enamel;
using station::render::Image;
using station::render::View;

constexpr int kTile_px = 420;
constexpr double kStride_m = 20e-6;

Image Beside(const Image& a, const Image& b) {
  Image out;
  out.width = a.width + b.width, out.height = a.height;
  for (int y = 0; y < a.height; ++y)
    for (const Image* i : {&a, &b}) {
      auto row = i->rgb.begin() + static_cast<std::ptrdiff_t>(y) * i->width * 3;
      out.rgb.insert(out.rgb.end(), row, row + i->width * 3);
    }
  return out;
}

struct Shot {
  View view = View::kOblique;
  dvec3 focus_m{0};
  double radius_m = 6.5e-3;
  int mesial_x = 1;
};

Image Draw(const cutting::Volume& volume, const cutting::Volume& uncut, const Shot& shot,
           const std::string& scratch) {
  station::render::WindowOptions options;
  options.screen.width_px = options.screen.height_px = kTile_px;
  options.screen.visible = options.panel = false;
  options.uncut = &uncut;
  options.view.view = shot.view;
  options.view.focus_m = shot.focus_m;
  options.view.view_radius_m = shot.radius_m;
  options.view.mesial_x = shot.mesial_x;
  options.view.burs = {{cutting::BurShape::kCylinder, 0.5e-3, 4e-3}};
  auto window = station::render::Window::Create(options, volume);
  Status status = window.ok() ? (*window)->WriteScreenshot(scratch) : window.status();
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.message().c_str());
  auto out = station::render::ReadPng(scratch);
  if (!out.ok()) std::exit(1);
  std::filesystem::remove(scratch);
  return std::move(*out);
}

// A bur led through a volume.
class Hand {
 public:
  Hand(cutting::Volume& volume, const cutting::Bur& bur) : cutter_(volume, bur) {}

  void At(const dvec3& tip_m, const Quat& orientation = {}) {
    cutter_.Cut({tip_m, orientation}, removed_);
  }
  void To(const dvec3& from_m, const dvec3& to_m) {
    dvec3 way = to_m - from_m;
    int n = static_cast<int>(std::sqrt(Dot(way, way)) / kStride_m) + 1;
    for (int i = 0; i <= n; ++i) At(from_m + way * (static_cast<double>(i) / n));
  }

 private:
  cutting::Cutter cutter_;
  cutting::RemovedUnits removed_{};
};

// Clears a box whose opening is above `floor` in layers, in rows along x.
void ClearBox(Hand& hand, double radius_m, const dvec3& floor_middle_m, double half_x_m,
              double half_y_m, double height_m) {
  double hx = half_x_m - radius_m, hy = half_y_m - radius_m;
  for (double z = height_m; z > -1e-9; z -= 0.25e-3) {
    for (double y = -hy; y < hy + 0.2e-3; y += 0.2e-3) {
      dvec3 from = floor_middle_m + dvec3(-hx, std::min(y, hy), std::max(z, 0.0));
      hand.To(from, from + dvec3(2 * hx, 0, 0));
    }
  }
}

dvec3 Landmark_m(const scene::Scene& scene, const char* name) {
  const scene::PointUm& p = scene.landmarks.at(name);
  return dvec3(p[0], p[1], p[2]) * 1e-6;
}

// A box in the fossa, with the mesial and distal ends of the fissure.
void CutClassOne(const scene::Scene& scene, cutting::Volume& volume) {
  constexpr double kRadius_m = 0.5e-3;
  Hand hand(volume, {cutting::BurShape::kCylinder, kRadius_m, 4e-3});
  dvec3 floor = Landmark_m(scene, "occlusal_centre") - dvec3(0, 0, 2e-3);
  ClearBox(hand, kRadius_m, floor, 2.0e-3, 1.2e-3, 4e-3);
  ClearBox(hand, kRadius_m, floor + dvec3(2.2e-3, 0, 0.2e-3), 0.9e-3, 1.6e-3, 4e-3);
  ClearBox(hand, kRadius_m, floor + dvec3(-2.2e-3, 0, 0.2e-3), 0.9e-3, 1.6e-3, 4e-3);
}

// The mesial box, and the isthmus that joins it to a box in the fossa.
void CutClassTwo(const scene::Scene& scene, cutting::Volume& volume) {
  constexpr double kRadius_m = 0.45e-3;
  Hand hand(volume, {cutting::BurShape::kCylinder, kRadius_m, 5e-3});
  dvec3 fossa = Landmark_m(scene, "occlusal_centre"), ridge = Landmark_m(scene, "mesial_box");
  double floor_z = fossa.z - 2.0e-3;
  const int mesial_x = scene::MesialX(scene.tooth);
  ClearBox(hand, kRadius_m, {0.5 * (fossa.x + ridge.x) - mesial_x * 0.4e-3, 0, floor_z}, 2.9e-3,
           1.0e-3, 4.5e-3);
  ClearBox(hand, kRadius_m, {fossa.x - mesial_x * 1.2e-3, fossa.y, floor_z}, 0.9e-3, 1.5e-3,
           4.5e-3);
  ClearBox(hand, kRadius_m, ridge - dvec3(0, 0, 3.5e-3), 0.99e-3, 1.7e-3, 4.5e-3);
}

// Point of the crown's outline at height z and angle t, mm, moved outward by `out`; the scene's
// frame.
dvec3 Outline_mm(const scene::ToothShape& tooth, double z, double t, double out) {
  auto half = scene::SectionAt_mm(tooth, z);
  double c = std::cos(t), s = std::sin(t);
  double a = tooth.Along(c) > 0 ? half[0] : half[1], b = s > 0 ? half[2] : half[3];
  double k =
      1 /
      std::sqrt(std::sqrt(c * c * c * c + s * s * s * s + tooth.sections.round * c * c * s * s));
  dvec3 p(a * k * c, b * k * s, z);
  // The outline is nearly round: its normal is nearly that of the ellipse.
  dvec3 n(c / a, s / b, 0);
  return p + n * (out / std::sqrt(Dot(n, n)));
}

// Occlusal surface and walls reduced all around, down to a shoulder; walls lean in by 5 degrees.
void CutCrown(const scene::ToothShape& tooth, cutting::Volume& volume) {
  constexpr double kRadius_mm = 0.6, kShoulder_mm = 1.0, kOcclusal_mm = 1.5, kLean = 0.087;
  double margin = tooth.cervical_z + 1.0;
  Hand round(volume, {cutting::BurShape::kSphere, 0.8e-3, 0});
  for (double y = -6; y <= 6; y += 0.12)
    for (double x = -6.5; x <= 6.5; x += 0.12) {
      double top = scene::OcclusalHeight_mm(tooth, x, y) - kOcclusal_mm;
      for (double z = std::max(top, 0.0); z < tooth.hi.z; z += 0.7) {
        round.At(dvec3(x, y, z) * 1e-3);
      }
    }
  Hand straight(volume, {cutting::BurShape::kCylinder, kRadius_mm * 1e-3, 9e-3});
  constexpr int kSteps = 1500;
  for (double out = 1.2; out > -1e-9; out -= 0.3) {
    for (int i = 0; i < kSteps; ++i) {
      double t = 2 * std::numbers::pi * i / kSteps;
      dvec3 tip = Outline_mm(tooth, margin, t, kRadius_mm - kShoulder_mm + out);
      // Turned about the tangent so that the shank leans over the tooth.
      Quat lean = Quat{std::sin(t) * kLean / 2, -std::cos(t) * kLean / 2, 0, 1}.Normalised();
      straight.At(tip * 1e-3, lean);
    }
  }
}

// The tooth cut open along a plane x = const or y = const, to show the tissues: without its mesial
// or its lingual half.
cutting::Volume CutOpen(const scene::BuiltScene& built, bool along_x) {
  scene::Preparation half;
  int32_t far = 30'000;
  half.parts.push_back({scene::PreparationPart::Outline::kBox,
                        along_x ? scene::PointUm{0, -far, 0}
                                : scene::PointUm{scene::MesialX(built.scene.tooth) * far, 0, 0},
                        {far, far},
                        far});
  return scene::Prepared(built.volume, half);
}

class Album {
 public:
  Album(std::filesystem::path folder, int32_t voxel_nm)
      : folder_(std::move(folder)), voxel_nm_(voxel_nm) {}

  scene::BuiltScene Build(const char* name) const {
    auto built = scene::BuildBuiltinScene(name, voxel_nm_);
    if (!built.ok()) std::fprintf(stderr, "%s\n", built.status().message().c_str());
    return std::move(*built);
  }

  // Draws the volume, changes it, draws it again.
  void BeforeAfter(const char* file, const cutting::Volume& uncut, const Shot& shot,
                   const std::function<void(cutting::Volume&)>& change) {
    Image before = Draw(uncut, uncut, shot, Scratch());
    cutting::Volume volume = uncut;
    volume.Reserve();
    change(volume);
    Write(file, Beside(before, Draw(volume, uncut, shot, Scratch())));
  }

  // `uncut`: of b.
  void Pair(const char* file, const cutting::Volume& a, const Shot& shot_a,
            const cutting::Volume& b, const Shot& shot_b, const cutting::Volume& uncut) {
    Image left = Draw(a, a, shot_a, Scratch());
    Write(file, Beside(left, Draw(b, uncut, shot_b, Scratch())));
  }

 private:
  std::string Scratch() const { return (folder_ / ".tile.png").string(); }
  void Write(const char* file, const Image& image) {
    auto path = folder_ / file;
    Status status = station::render::WritePng(path.string(), image);
    std::printf("%s\n", status.ok() ? path.c_str() : status.message().c_str());
    std::fflush(stdout);
  }

  std::filesystem::path folder_;
  int32_t voxel_nm_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: tooth_pictures FOLDER [voxel_um]\n");
    return 2;
  }
  station::render::VirtualDisplay display;
  Album album(argv[1], argc > 2 ? std::atoi(argv[2]) * 1000 : 50'000);
  {
    auto built = album.Build("molar");
    const int mesial_x = scene::MesialX(built.scene.tooth);
    album.BeforeAfter("tooth_class_1.png", built.volume, {.mesial_x = mesial_x},
                      [&](cutting::Volume& v) { CutClassOne(built.scene, v); });
    album.BeforeAfter("tooth_crown.png", built.volume,
                      {View::kOblique, {0, 0, -1e-3}, 7e-3, mesial_x},
                      [&](cutting::Volume& v) { CutCrown(scene::LowerFirstMolar(), v); });
    album.Pair("tooth_molar.png", built.volume, {View::kBuccal, {0, 0, -6.9e-3}, 12.2e-3, mesial_x},
               CutOpen(built, false), {View::kMesial, {0, 0, -6.9e-3}, 12.2e-3, mesial_x},
               built.volume);
  }
  {
    auto built = album.Build("molar-class-2");
    const int mesial_x = scene::MesialX(built.scene.tooth);
    album.BeforeAfter("tooth_class_2.png", built.volume,
                      {View::kOblique, {mesial_x * 3.5e-3, 0, 1e-3}, 7.5e-3, mesial_x},
                      [&](cutting::Volume& v) { CutClassTwo(built.scene, v); });
  }
  for (const char* name : {"premolar", "incisor"}) {
    auto built = album.Build(name);
    const int mesial_x = scene::MesialX(built.scene.tooth);
    album.Pair((std::string("tooth_") + name + ".png").c_str(), built.volume,
               {View::kBuccal, {0, 0, -6.5e-3}, 12.8e-3, mesial_x}, CutOpen(built, false),
               {View::kMesial, {0, 0, -6.5e-3}, 12.8e-3, mesial_x}, built.volume);
  }
  {
    auto built = album.Build("block");
    cutting::Volume shaped = built.volume;
    for (const auto& p : built.scene.preparations) shaped = scene::Prepared(shaped, p);
    auto caries = album.Build("molar-caries");
    album.Pair("tooth_block_caries.png", shaped, {View::kOblique, {0, 0, 4e-3}, 12e-3},
               CutOpen(caries, true),
               {View::kOblique, {0, 0, 0}, 7e-3, scene::MesialX(caries.scene.tooth)},
               caries.volume);
  }
}
