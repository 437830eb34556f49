#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "common/base/unix_time.h"
#include "common/program/example.h"
#include "common/program/log.h"
#include "station/desk/exercise_words.h"
#include "station/desk/pages.h"
#include "station/lab/bench/bench.h"
#include "station/render/window.h"

namespace enamel::station::lab::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct IdleOptions {
  int width_px = 1920, height_px = 1080;
  double seconds = 10;
  std::string json;
};

constexpr double kGoal_percent = 3;
constexpr int kIdleExercises = 24;  // a list that has to be scrolled

// A class with some of all that a card can show.
std::vector<Catalogue::Exercise> Exercises(int count) {
  std::vector<Catalogue::Exercise> all(static_cast<size_t>(count));
  for (size_t i = 0; i < all.size(); ++i) {
    Catalogue::Exercise& exercise = all[i];
    exercise.title = "Class II cavity, mesial box, " + std::to_string(i + 1);
    exercise.due_unix_ms = UnixMs() + 86'400'000;
    exercise.attempt_limit = 12;
    exercise.attempts_left = 11;
    exercise.best_score = 87;
    exercise.facts = Catalogue::Facts{46, "mesial_box", true, true, i % 2 == 0};
  }
  return all;
}

// Watches the window's list of exercises while nobody touches it. Errors: kUnavailable without a
// display.
Status BenchIdle(const IdleOptions& options, Rows& rows) {
  try {
    render::ScreenOptions window;
    window.width_px = options.width_px;
    window.height_px = options.height_px;
    render::Screen screen(window);
    desk::Ui ui(screen);
    const language::Words words(language::Language::kEnglish);
    const auto exercises = Exercises(kIdleExercises);
    const auto frame = [&] {
      (void)screen.Begin();
      std::vector<desk::Card> cards;
      for (const auto& exercise : exercises) {
        cards.push_back(desk::CardOf(words, exercise, UnixMs()));
      }
      ui.Begin("exercises", desk::kWidePage);
      ui.Title(words.Say("exercises.hello", {{"name", std::string("Ada")}}));
      ui.BeginList("exercises");
      (void)ui.Cards(cards);
      ui.EndList();
      (void)ui.Button(words.Say("exercises.sign_out"));
      ui.End();
      ui.EndFrame();
      screen.End();
    };
    for (int i = 0; i < 30; ++i) frame();
    const std::clock_t cpu = std::clock();
    const auto began = Clock::now();
    const uint64_t drawn = screen.drawn();
    int frames = 0;
    double wall_s = 0;
    while (wall_s < options.seconds) {
      frame();
      ++frames;
      wall_s = std::chrono::duration<double>(Clock::now() - began).count();
    }
    const double cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    const double percent = 100 * cpu_s / wall_s;
    std::printf(
        "renderer   %s\n"
        "method     list of %d exercises, %d x %d, untouched for %.0f s; processor time of all "
        "threads by wall time\n\n"
        "processor  %s %% of a core; %d frames, %llu of them drawn\n",
        screen.renderer().c_str(), kIdleExercises, screen.width(), screen.height(), wall_s,
        AgainstGoal(percent, kGoal_percent).c_str(), frames,
        static_cast<unsigned long long>(screen.drawn() - drawn));
    rows.Add({{"exercises", kIdleExercises},
              {"width_px", screen.width()},
              {"height_px", screen.height()},
              {"cpu_percent", percent},
              {"frames", frames},
              {"drawn", screen.drawn() - drawn}});
    return Status::Ok();
  } catch (const std::exception& e) {
    return render::NoDisplay(e.what());
  }
}

}  // namespace

void RegisterIdle(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<IdleOptions>();
  CLI::App* idle = app.add_subcommand(
      "idle", "The processor's share of the list of exercises while nobody touches it");
  idle->add_option("--width", options->width_px, "Of the window, pixels")->capture_default_str();
  idle->add_option("--height", options->height_px, "Of the window, pixels")->capture_default_str();
  idle->add_option("--seconds", options->seconds, "How long it is watched")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  idle->add_option("--json", options->json, "Write the figures to this file");
  program::AddExamples(*idle, {"--seconds 10"});
  idle->callback([options, exit_code] {
    *exit_code = 1;
    if (!CanWrite(options->json)) return;
    Rows rows("idle", "processor time of all threads by wall time, untouched");
    const Status measured = BenchIdle(*options, rows);
    if (!measured.ok()) return program::SayError(measured.message());
    *exit_code = rows.Write(options->json);
  });
}

}  // namespace enamel::station::lab::bench
