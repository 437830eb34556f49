#include "station/lab/app/pictures_command.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/program/log.h"
#include "common/program/output.h"
#include "common/scene/builtin/builtin.h"
#include "station/lab/pictures/kept_views.h"
#include "station/lab/pictures/picture_change.h"
#include "station/render/window.h"

namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;
using render::Image;

struct PicturesCommand {
  std::vector<std::string> scenes;
  fs::path out = "pictures", compare;
};

// What became of the pictures of one run.
class Comparison {
 public:
  explicit Comparison(const PicturesCommand& command) : command_(command) {}

  Status Take(const std::string& name, const Image& now) {
    drawn_.insert(name);
    if (command_.compare.empty()) return Write(name, now);
    const auto kept = render::ReadPng(Kept(name));
    if (!kept.ok() && kept.status().code() != Code::kNotFound) return kept.status();
    if (!kept.ok()) return Differs(name, now, "not kept yet");
    const auto change = ChangeBetween(*kept, now);
    if (!change) return Differs(name, now, "kept at another size");
    std::printf("%-36s %7.4f %7.4f%s\n", name.c_str(), change->worst, change->mean,
                change->seen() ? "  CHANGED" : "");
    if (!change->seen()) return Status::Ok();
    ENAMEL_RETURN_IF_ERROR(Write(name + ".kept", *kept));
    ENAMEL_RETURN_IF_ERROR(Write(name + ".difference", change->map));
    char what[120];
    std::snprintf(what, sizeof what, "changed: %.4f around (%d, %d), noticed from %.3f",
                  change->worst, change->x, change->y, kNoticed);
    return Differs(name, now, what);
  }

  // Kept pictures of a whole run that nothing draws.
  void FindOrphans() {
    if (command_.compare.empty() || !command_.scenes.empty()) return;
    for (const auto& file : fs::directory_iterator(command_.compare)) {
      const fs::path& path = file.path();
      if (path.extension() != ".png" || drawn_.contains(path.stem())) continue;
      lines_.push_back(path.stem().string() + ": nothing draws it; to accept: rm " + path.string());
    }
  }

  // All that a person should look at.
  Status Verdict() const {
    std::printf("\n");
    for (const std::string& line : lines_) std::printf("%s\n", line.c_str());
    if (command_.compare.empty()) {
      std::printf("%zu pictures in %s\n", drawn_.size(), command_.out.c_str());
    } else {
      std::printf("%zu pictures compared, different: %zu\n", drawn_.size(), lines_.size());
    }
    if (lines_.empty()) return Status::Ok();
    return Status(Code::kConflict,
                  "look at what differs from the kept pictures, and accept what should be so with "
                  "the commands above");
  }

 private:
  std::string Kept(const std::string& name) const { return command_.compare / (name + ".png"); }
  Status Write(const std::string& name, const Image& image) const {
    return render::WritePng(command_.out / (name + ".png"), image);
  }
  Status Differs(const std::string& name, const Image& now, const std::string& what) {
    ENAMEL_RETURN_IF_ERROR(Write(name, now));
    lines_.push_back(name + ": " + what + "; to accept: cp " +
                     (command_.out / (name + ".png")).string() + " " + Kept(name));
    return Status::Ok();
  }

  const PicturesCommand& command_;
  std::set<std::string> drawn_;
  std::vector<std::string> lines_;
};

Status RunPictures(const PicturesCommand& command) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFolder(command.out, "--out"));
  std::error_code error;
  if (!command.compare.empty() && !fs::is_directory(command.compare, error)) {
    return Status(Code::kInvalidInput,
                  "--compare: expected a folder of kept pictures, found none at " +
                      command.compare.string() + "; draw one with --out");
  }
  fs::create_directories(command.out, error);
  Comparison comparison(command);
  if (!command.compare.empty()) std::printf("%-36s %7s %7s\n", "picture", "worst", "mean");
  try {
    render::ScreenOptions window;
    window.width_px = kKeptWidth_px, window.height_px = kKeptHeight_px;
    window.visible = window.paced = false;
    const render::Screen screen(window);
    for (const std::string& name :
         command.scenes.empty() ? scene::BuiltinSceneNames() : command.scenes) {
      ENAMEL_RETURN_IF_ERROR(
          DrawKeptViews(name, screen, [&](const std::string& picture, const Image& image) {
            return comparison.Take(picture, image);
          }));
    }
  } catch (const std::exception& e) {
    // Windows and drivers throw; the error gets a remedy here.
    return render::NoDisplay(e.what());
  }
  comparison.FindOrphans();
  return comparison.Verdict();
}

}  // namespace

void RegisterPictures(CLI::App& app, int* exit_code) {
  auto command = std::make_shared<PicturesCommand>();
  CLI::App* pictures = app.add_subcommand(
      "pictures", "Draw the teeth and exercises at set views, and compare them with kept pictures");
  pictures->add_option("scene", command->scenes, "Some of the built-in scenes (molar); else all")
      ->type_name("SCENE")
      ->check(CLI::IsMember(scene::BuiltinSceneNames()));
  pictures->add_option("--compare", command->compare, "Folder of kept pictures");
  pictures
      ->add_option("--out", command->out,
                   "Folder for the pictures; with --compare only for those that differ")
      ->capture_default_str();
  pictures->footer(
      "Each scene in the mouth (SCENE.mouth), cut open (SCENE.open), with a bur in it (SCENE.bur)\n"
      "and a mirror (SCENE.mirror); each exercise as it begins (EXERCISE.start) and prepared as "
      "it\n"
      "asks for (EXERCISE.target).\n"
      "A comparison prints two figures of FLIP, a published measure of how different two pictures\n"
      "look to a person who alternates between them, 0 to 1: worst is the mean of the worst "
      "degree\n"
      "of the viewer's field, mean that of the whole picture. A picture whose worst is noticeable\n"
      "is written to --out beside the kept one (NAME.kept.png) and a picture of the differences\n"
      "(NAME.difference.png, bright where they are). Look at all three, then either mend the\n"
      "change or accept it with the command printed.\n"
      "Drivers draw a little differently: kept pictures are drawn by Mesa's llvmpipe, on any\n"
      "computer: LIBGL_ALWAYS_SOFTWARE=1.\n"
      "Examples:\n"
      "  xvfb-run enamel-lab pictures --compare tests/golden/pictures\n"
      "  xvfb-run enamel-lab pictures molar-caries --out look\n"
      "Exit codes: 0 drawn, none differs; 1 some differ, or failed.");
  pictures->callback([command, exit_code] {
    const Status status = RunPictures(*command);
    if (!status.ok()) program::SayError("pictures: " + status.message());
    *exit_code = status.ok() ? 0 : 1;
  });
}

}  // namespace enamel::station::lab
