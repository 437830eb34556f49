#include "station/lab/app/cli.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "common/program/example.h"
#include "common/program/log.h"
#include "station/lab/app/explain.h"
#include "station/lab/app/grades_command.h"
#include "station/lab/app/paper_command.h"
#include "station/lab/app/pictures_command.h"
#include "station/lab/app/qualify.h"
#include "station/lab/app/reasons_command.h"
#include "station/lab/bench/bench.h"
#include "station/lab/tissue/fit_damping.h"

namespace enamel::station::lab {

namespace {

constexpr char kFooter[] = R"(Which question is answered by which command:
  does a force law hold on this device?           enamel-lab qualify --profile omega3 --quick
  ... in numbers and pictures                     enamel-lab qualify --profile omega3 --report omega3.html
  what became of the paper this began with?       enamel-lab paper
  what does more accuracy cost?                   enamel-lab error --quick
  is this computer fast enough for a tick?        enamel-lab bench tick --quick
  ... for a picture                               enamel-lab bench frames --frames 60
  did a change alter how a tooth looks?           enamel-lab pictures --compare tests/golden/pictures
  what of a scene is carried, and within budget?  enamel-lab explain builtin:molar --budget-us 200
  does a grade find what was done wrong?          enamel-lab grades --quick
  what does a grade say of each fault?            enamel-lab reasons --sheet reasons.html
  does a grade tell skill?                        enamel-lab operators --quick
  how hard is a tissue to cut, from a recording?  enamel-lab fit-damping cut.csv --material cut.json
Every command has its own --help. Most write their rows with --json FILE.
Settings: as those of enamel-station (schemas/station_settings.md); keys of its file that are not
the lab's are passed over.
Exit codes: 0 done, 1 failed (the reason is on standard error), 2 wrong command line, or a force law
that is proved passive gave energy.)";

void RegisterQualify(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<QualifyOptions>();
  options->out = stdout;
  // Passed to a function instead of printed: tests run suites without a terminal.
  options->errors = [](const std::string& why) { program::SayError("qualify: " + why); };
  CLI::App* qualify = app.add_subcommand("qualify",
                                         "Measure force laws on a device profile: error against "
                                         "run time, stability, a search for energy");
  qualify
      ->add_option("--profile", options->profile,
                   "device profile, a profile document (….json), or all")
      ->capture_default_str();
  qualify->add_option("--suite", options->suites, "What to measure, separated by commas")
      ->check(CLI::IsMember(SuiteNames()))
      ->delimiter(',')
      ->capture_default_str();
  qualify->add_flag("--quick", options->quick, "under a minute on two cores");
  qualify->add_option("--json", options->json_path, "write every row to this file");
  qualify->add_option("--report", options->report,
                      "draw a page to open in a browser: F.html, with F.json beside it; or a "
                      "folder, report.html and qualification.json in it");
  qualify
      ->add_option("--motion", options->motion,
                   "hand, strokes, watch: CSV file of a person's motion (t_s,px_m,py_m,pz_m at 1 "
                   "kHz), or a folder "
                   "of them, in place of the generated hands")
      ->type_name("PATH");
  qualify->add_option("--calibration", options->calibration,
                      "calibration: what `enamel-station calibrate` wrote of the device");
  qualify->add_option("--cases", options->cases, "random: how many")->capture_default_str();
  qualify
      ->add_option("--ticks", options->adversary_ticks,
                   "adversary: how many over all laws (0: the suite's own)")
      ->check(CLI::NonNegativeNumber);
  qualify->add_option("--seed", options->seed, "of everything drawn")->capture_default_str();
  qualify->add_option("--threads", options->threads, "threads to use")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  qualify->footer(
      "Suites:\n"
      "  paper       the tables of Liu et al. 2008 beside what this law does in the same cases\n"
      "  hand        the law in hands that give: the command against an ideal damper in the same "
      "hand, rounded and\n"
      "              noisy positions, lifts, hands that push, first strokes, withdrawals; the "
      "force "
      "in the hand, with\n"
      "              the device's friction and inertia, and what its error is made of\n"
      "  map         up to which grip cutting feels right, by device, loop rate, tissue and law, "
      "beside "
      "the closed\n"
      "              form; Kc at each rate and what limits it (schemas/feel.schema.json)\n"
      "  strokes     what a hand feels in the strokes of the built-in exercises, on the devices as "
      "shipped: not\n"
      "              measured and calibrated\n"
      "  withdrawal  press, stroke, reverse, lift, nick, slip-out with the product's core: force "
      "against time\n"
      "              beside the ideal (schemas/strokes.schema.json)\n"
      "  calibration what stays safe if a calibration is wrong: Kc at the bad end of each interval "
      "(--calibration)\n"
      "  laws        every force law on the same cuts: error against run time\n"
      "  front       voxel, loop rate, law and estimator together: what a whole tick costs, and "
      "what "
      "a hand gets\n"
      "              for it; what the next halving costs and buys\n"
      "  estimators  every velocity estimator on the same cuts\n"
      "  extreme     stiff tissue, light hands, held ticks: where each law is passive, bounded or "
      "unstable\n"
      "  adversary   a search for motions that draw energy from the coupling; exit code 2 when one "
      "is found\n"
      "  random      devices, tissues and hands drawn from --seed: how many hold every bound\n"
      "  cutting     error of the cut against its run time, by voxel size\n"
      "Examples:\n"
      "  enamel-lab qualify --profile omega3 --suite hand --quick\n"
      "  enamel-lab qualify --profile my_device.json --suite map,hand\n"
      "  enamel-lab qualify --profile omega3 --suite withdrawal --json strokes.json\n"
      "  enamel-lab qualify --profile omega3 --report omega3.html\n"
      "A page is drawn by node and draw_report.mjs, which are installed with this program; the\n"
      "JSON can be attached to the device on the server, whose page draws it too.\n"
      "Exit codes: 0 measured, 1 failed, 2 a proved law gave energy.");
  qualify->callback([options, exit_code] {
    if (::isatty(STDERR_FILENO) != 0 && !program::LogIsJson()) options->progress = stderr;
    *exit_code = RunQualify(*options);
  });
}

void RegisterFitDamping(CLI::App& app, int* exit_code) {
  auto fitting = std::make_shared<FitDampingOptions>();
  CLI::App* fit = app.add_subcommand(
      "fit-damping",
      "Fit a tissue's damping B (a matrix, or along and across the bur), Coulomb part and cutting "
      "threshold from a CSV of time, position and force");
  fit->add_option(
         "csv", fitting->csv_path,
         "columns time_s, position_mm (or x_mm, y_mm, z_mm), force_n (or fx_n, fy_n, fz_n),\n"
         "optionally axis_x, axis_y, axis_z and tissue; 1 kHz is best, 40 Hz does for B alone")
      ->required();
  fit->add_option("--bur-axis", fitting->bur_axis,
                  "the bur's axis x,y,z in the frame of the positions: B along and across it");
  fit->add_option("--plot", fitting->plot_path,
                  "draw force against speed as a page: F.html, with F.json beside it");
  fit->add_option("--material", fitting->material_path,
                  "store the fit as a material profile (JSON) for scenes");
  fit->footer(
      "F = B V + Fc V/|V| while cutting; nothing is cut below the threshold. Example, a recording "
      "of\n"
      "a minute at 1 kHz:\n"
      "  time_s,x_mm,y_mm,z_mm,fx_n,fy_n,fz_n,tissue\n"
      "  0.000,1.2330,0.4410,-0.8820,0.31,-0.02,-1.18,enamel\n"
      "  0.001,1.2330,0.4410,-0.8910,0.33,-0.02,-1.20,enamel\n"
      "  enamel-lab fit-damping cut.csv --plot cut.html --material cut.json\n"
      "What the recording must hold: speeds that differ by a factor of two or more (B apart from "
      "Fc),\n"
      "at least three directions that are not in a plane (the matrix; one B otherwise), slow "
      "presses\n"
      "that stick, and stops (the threshold). A warning names what it lacks.");
  fit->callback([fitting, exit_code] { *exit_code = RunFitDamping(*fitting); });
}

void RegisterExplain(CLI::App& app, int* exit_code) {
  auto explain = std::make_shared<ExplainCommand>();
  CLI::App* command = app.add_subcommand(
      "explain", "Parts of a scene in an attempt, parts left out and why, measured here");
  command
      ->add_option("scene", explain->scene,
                   "builtin:NAME ('scenes' lists them) or an imported scene's folder")
      ->capture_default_str();
  command->add_option("--exercise", explain->exercise,
                      "Name ('scenes' lists them) or kind, as class-1; else the scene's first");
  command->add_option("--profile", explain->profile, "Device profile, or its document (FILE.json)")
      ->capture_default_str();
  command->add_option("--voxel-um", explain->voxel_um, "Voxel of a built-in scene")
      ->capture_default_str();
  command->add_option("--memory-mb", explain->memory_mb, "What a built-in scene may take at most")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_flag("--window", explain->window, "For an attempt with a window");
  command->add_flag("--replay", explain->replay, "For re-running a recording");
  command
      ->add_option(
          "--budget-us", explain->budget_us,
          "Of a tick: picks the voxel, law and rate that fit and are felt best in practice "
          "(the joint front of 'qualify --suite front'); a graded exercise is "
          "checked against it")
      ->check(CLI::PositiveNumber);
  command->add_option("--json", explain->json, "Write the facts to this file");
  program::AddExamples(*command, {"builtin:molar --exercise class-1 --budget-us 200"});
  // The command prints a refusal itself: unlike a suite it has no caller that could.
  command->callback([explain, exit_code] {
    Status status = ExplainScene(*explain);
    if (!status.ok()) program::SayError(status.message());
    *exit_code = status.ok() ? 0 : 1;
  });
}

void RegisterError(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<QualifyOptions>();
  // A suite with its own name, for people who do not judge force laws.
  options->suites = {"cutting"};
  options->out = stdout;
  options->errors = [](const std::string& why) { program::SayError("error: " + why); };
  CLI::App* error =
      app.add_subcommand("error", "Error against run time of cutting: burs, voxel sizes, scores");
  error->add_flag("--quick", options->quick, "Two burs, one speed, two voxel sizes, no scores");
  error->add_option("--json", options->json_path, "Write the rows to this file");
  error->add_option("--report", options->report,
                    "Draw a page with the Pareto front: F.html, with F.json beside it; or a "
                    "folder");
  error->footer(
      "The same as 'qualify --suite cutting'. Every bur and voxel size, beside what a tick of it\n"
      "costs here: removed volume, surface and force against closed forms, in a groove and in a\n"
      "plunge, on eight grids that lie differently; the order in which each error falls with the\n"
      "voxel, or its floor, also of scores, meshes, pictures and simulated devices; and the score "
      "of\n"
      "one hand at every voxel size.\n"
      "Examples:\n"
      "  enamel-lab error --quick\n"
      "  enamel-lab error --report cutting.html\n"
      "Force laws' error against run time: 'enamel-lab qualify --suite laws'.\n"
      "Exit codes: 0 measured, 1 failed.");
  error->callback([options, exit_code] {
    if (::isatty(STDERR_FILENO) != 0 && !program::LogIsJson()) options->progress = stderr;
    *exit_code = RunQualify(*options);
  });
}

}  // namespace

// In the order of `--help`: the most common first.
void RegisterLab(CLI::App& app, int* exit_code) {
  RegisterQualify(app, exit_code);
  RegisterPaper(app, exit_code);
  RegisterError(app, exit_code);
  bench::RegisterBench(app, exit_code);
  RegisterExplain(app, exit_code);
  RegisterFitDamping(app, exit_code);
  RegisterGrades(app, exit_code);
  RegisterReasons(app, exit_code);
  RegisterOperators(app, exit_code);
  RegisterHandSigns(app, exit_code);
  RegisterPictures(app, exit_code);
  // After the commands, which would inherit it.
  app.footer(kFooter);
}

}  // namespace enamel::station::lab
