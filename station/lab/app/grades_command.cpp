#include "station/lab/app/grades_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <memory>

#include "common/program/log.h"
#include "common/program/output.h"
#include "station/lab/bench/bench.h"
#include "station/lab/grades/figures.h"
#include "station/lab/grades/grades.h"
#include "station/lab/grades/hand_signs.h"
#include "station/lab/grades/mixtures.h"
#include "station/lab/grades/operators.h"

namespace enamel::station::lab {
namespace {

struct GradesCommand {
  GradesOptions options;
  std::vector<int> voxels_um;
  int mixtures = 0, offsets = 0;
  uint64_t seed = 1;
  std::string json;
};

Status WriteRows(const std::string& path, const boost::json::object& document) {
  return path.empty() ? Status::Ok() : program::WriteJsonFile(path, document);
}

void PrintRow(const GradeRow& r) {
  char found[24] = "-";
  if (r.found) std::snprintf(found, sizeof found, "%.4f", *r.found);
  const bool as_expected = r.critical.empty() == r.critical_expected.empty();
  std::printf("%-26s %-20s %9.3f %-4s %6.3f  %-24s %9s %-3s %7.2f %7.2f%s%s%s%s\n",
              r.exercise.c_str(), r.fault.c_str(), r.size, r.unit.c_str(), r.voxel_mm,
              r.metric.c_str(), found, r.AsKnown() ? "" : "off", r.points_lost, r.score,
              r.CostsEnough() ? "" : "  too little", r.CostsTooMuch() ? "  too much" : "",
              r.critical.empty() ? "" : ("  " + r.critical).c_str(),
              as_expected ? "" : "  UNEXPECTED");
}

Status RunGrades(const GradesCommand& command) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(command.json, "--json"));
  bench::Progress progress;
  std::printf("%-26s %-20s %9s %-4s %6s  %-24s %9s %-3s %7s %7s\n", "exercise", "fault", "size",
              "unit", "voxel", "metric", "found", "", "lost", "score");
  auto print = [&](const GradeRow& row) {
    progress.Clear();
    PrintRow(row);
  };
  ENAMEL_ASSIGN_OR_RETURN(
      const auto rows,
      MeasureGrades(command.options, print,
                    [&](const std::string& what, double ratio) { progress.Show(what, ratio); }));
  progress.Clear();
  std::printf("\n");
  for (const GradeFigure& figure : FiguresOf(rows)) {
    std::printf("%12s  %s\n", figure.value.c_str(), figure.what.c_str());
    for (const std::string& miss : figure.misses) std::printf("%16s%s\n", "", miss.c_str());
  }
  return WriteRows(command.json, GradesJson(rows));
}

// Fails where a law is broken: no grade may be given by such points.
Status RunMixtures(const GradesCommand& command) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(command.json, "--json"));
  MixturesOptions options;
  options.count = command.mixtures;
  options.offsets = command.offsets;
  options.seed = command.seed;
  options.exercises = command.options.exercises;
  if (!command.voxels_um.empty()) options.voxels_nm = command.options.voxels_nm;
  bench::Progress progress;
  std::printf("%-26s %6s %6s %7s %7s %7s  %s\n", "exercise", "voxel", "seed", "score", "larger",
              "further", "faults");
  size_t broken = 0;
  auto print = [&](const MixtureRow& r) {
    progress.Clear();
    std::string faults;
    for (const std::string& fault : r.faults) faults += (faults.empty() ? "" : ", ") + fault;
    const double larger = r.larger.empty() ? r.score : std::ranges::max(r.larger);
    std::printf("%-26s %6.3f %6llu %7.2f %7.2f %7.2f  %s\n", r.exercise.c_str(), r.voxel_mm,
                static_cast<unsigned long long>(r.seed), r.score, larger, r.further,
                faults.c_str());
    for (const std::string& law : r.broken) std::printf("%28sBROKEN: %s\n", "", law.c_str());
    for (const std::string& what : r.wrong) std::printf("%28sFALSE: %s\n", "", what.c_str());
    for (const std::string& fault : r.missed) std::printf("%28snot named: %s\n", "", fault.c_str());
    broken += r.broken.size();
  };
  ENAMEL_ASSIGN_OR_RETURN(const auto rows,
                          TryMixtures(options, print, [&](const std::string& what, double ratio) {
                            progress.Show(what, ratio);
                          }));
  progress.Clear();
  const boost::json::object document = MixturesJson(rows);
  const auto said = [&](const char* name) { return document.at(name).to_number<double>(); };
  std::printf(
      "\n%12zu  laws broken in %zu mixtures\n%12.1e  points, the largest difference between the "
      "mistakes' points and the loss\n%12.0f  of %.0f sentences are false\n%12.0f  of %.0f faults "
      "that alone cost a point are named at a region that they reach\n%12.0f  of %.0f mistakes of "
      "a "
      "point and more are at no such region\n%12.1f  %% of the points are lost to faults that no "
      "mistake explains\n",
      broken, rows.size(), said("sum_error"), said("sentences_false"), said("sentences"),
      said("faults_found"), said("faults_asked"), said("mistakes_invented"), said("mistakes"),
      100 * said("uneven_share"));
  if (options.offsets > 0) {
    std::vector<double> spread;
    for (const MixtureRow& r : rows) spread.push_back(r.offset_spread);
    std::ranges::sort(spread);
    std::printf(
        "%12.2f  points, the 95th percentile of a mixture's spread over %d places in the grid\n",
        spread[(spread.size() * 95 - 1) / 100], options.offsets + 1);
  }
  ENAMEL_RETURN_IF_ERROR(WriteRows(command.json, document));
  return broken == 0 ? Status::Ok()
                     : Status(Code::kInternal, std::to_string(broken) + " laws are broken");
}

struct OperatorsCommand {
  OperatorsOptions options;
  std::string json;
};

Status RunOperators(const OperatorsCommand& command) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(command.json, "--json"));
  bench::Progress progress;
  std::printf("%-26s %-16s %-20s %4s %6s %7s\n", "exercise", "device", "operator", "rank", "seed",
              "score");
  auto print = [&](const OperatorRow& r) {
    progress.Clear();
    std::printf("%-26s %-16s %-20s %4d %6llu %7.2f%s\n", r.exercise.c_str(), r.device.c_str(),
                r.name.c_str(), r.rank, static_cast<unsigned long long>(r.seed), r.score,
                r.critical_fail ? "  failed critically" : "");
  };
  auto show = [&](const std::string& what, double ratio) { progress.Show(what, ratio); };
  ENAMEL_ASSIGN_OR_RETURN(const auto findings, MeasureOperators(command.options, print, show));
  progress.Clear();
  std::printf("\n");
  for (const SkillOrder& o : findings.order) {
    std::printf("%-26s %-16s Spearman of rank and score %s\n", o.exercise.c_str(), o.device.c_str(),
                bench::AgainstGoal(o.spearman, 0.93, true).c_str());
  }
  for (const EqualSkill& e : findings.equal_skill) {
    std::printf("%-26s %-16s mean scores on the devices differ by %s points (%zu seeds)\n",
                e.exercise.c_str(), e.name.c_str(), bench::AgainstGoal(e.points, 2, false).c_str(),
                e.seeds);
  }
  if (const FullMarks marks = FullMarksOf(findings.rows, "student"); marks.rows > 0) {
    const double percent = 100 * static_cast<double>(marks.full) / static_cast<double>(marks.rows);
    std::printf("%zu of %zu attempts of the student have 100 points: %s %%\n", marks.full,
                marks.rows, bench::AgainstGoal(percent, 5, false).c_str());
  }
  for (const std::string& name : findings.not_cut) {
    std::printf("%s: not measured, no simulated person cuts its shape\n", name.c_str());
  }
  for (const LeftOut& l : findings.left_out) {
    std::printf("%s, %s: without %s, who has no plan for it\n", l.exercise.c_str(),
                l.device.c_str(), l.name.c_str());
  }
  return WriteRows(command.json, OperatorsJson(findings));
}

struct HandSignsCommand {
  HandSignsOptions options;
  std::string json;
};

Status RunHandSigns(const HandSignsCommand& command) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(command.json, "--json"));
  bench::Progress progress;
  auto show = [&](const std::string& what, double ratio) { progress.Show(what, ratio); };
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, MeasureHandSigns(command.options, show));
  progress.Clear();
  std::printf("%-34s %7s %9s %6s %9s   %s\n", "figure of a motion", "people", "programs", "area",
              "std error", "programs found where 5, 10, 20 % of people are taken for one");
  for (const SignRoc& row : rows) {
    std::printf("%-34s %7zu %9zu %6.3f %9.3f   %5.1f %% %5.1f %% %5.1f %%\n", row.sign.c_str(),
                row.people, row.programs, row.area, row.standard_error, 100 * row.found_at_5,
                100 * row.found_at_10, 100 * row.found_at_20);
  }
  for (const SignRoc& row : rows) {
    if (!row.threshold) continue;
    std::printf("%s below %g: %.1f %% of people's by mistake, %.1f %% of programs'\n",
                row.sign.c_str(), *row.threshold, 100 * row.mistaken, 100 * row.found);
  }
  return WriteRows(command.json, HandSignsJson(rows));
}

}  // namespace

void RegisterHandSigns(CLI::App& app, int* exit_code) {
  auto command = std::make_shared<HandSignsCommand>();
  CLI::App* signs = app.add_subcommand(
      "hand-signs", "How well figures of a motion tell a simulated hand from a person's");
  signs->add_option("--people", command->options.people, "Folder of people's motions: CSV, 1 kHz")
      ->required();
  signs->add_option("--operator", command->options.operators, "Simulated people")
      ->delimiter(',')
      ->capture_default_str();
  signs->add_option("--exercise", command->options.exercise, "Of the block")->capture_default_str();
  signs->add_option("--seconds", command->options.seconds, "Of each simulated person")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  signs->add_option("--json", command->json, "Write the rows to this file");
  signs->footer(
      "A row for each figure: the area under its receiver operating characteristic (the chance\n"
      "that a program's second has the higher figure; 0.5 separates nothing, 0 and 1 all)\n"
      "with its standard error, and the share of programs found at three rates of false alarm. It\n"
      "decides nothing: the signed recording says what holds the tool. People who do something\n"
      "other than cutting a tooth differ for that reason too. The last two rows: the nearness of "
      "a\n"
      "copy to a person's motion, and of a simulated person's motion to another run, against\n"
      "people who repeated a motion.\n"
      "Example:\n"
      "  enamel-lab hand-signs --people ../shared/data/motion\n"
      "The JSON: schemas/lab_hand_signs.schema.json. Exit codes: 0 measured, 1 failed.");
  signs->callback([command, exit_code] {
    const Status status = RunHandSigns(*command);
    if (!status.ok()) program::SayError("hand-signs: " + status.message());
    *exit_code = status.ok() ? 0 : 1;
  });
}

void RegisterOperators(CLI::App& app, int* exit_code) {
  auto command = std::make_shared<OperatorsCommand>();
  CLI::App* operators =
      app.add_subcommand("operators", "Do scores put simulated people in the order of their skill");
  operators->add_flag("--quick", command->options.quick, "One device, one seed");
  operators->add_option("--device", command->options.devices, "Built-in device profiles")
      ->delimiter(',')
      ->capture_default_str();
  operators
      ->add_option("--exercise", command->options.exercises,
                   "Names or their beginnings (class-1, caries); else all they can cut")
      ->delimiter(',');
  operators
      ->add_option("--seed", command->options.seeds, "Of tremor and mistakes; 0: each person's own")
      ->delimiter(',')
      ->capture_default_str();
  operators
      ->add_option("--operator", command->options.operators,
                   "Some of the eight people (student); else all")
      ->delimiter(',');
  operators->add_option("--json", command->json, "Write the rows to this file");
  operators->footer(
      "Eight simulated people have a published rank of skill: the less skilled err more, and make\n"
      "more mistakes. A seed draws which. All of them do each exercise with each device and are\n"
      "graded against the dentist among them. Spearman's correlation of rank and score shows how\n"
      "well the grade reflects skill; work that is not acceptable has 0 points and ranks lowest.\n"
      "The same hand should get the same grade with every device: the means over its seeds are\n"
      "compared.\n"
      "An exercise takes some minutes per device and seed.\n"
      "Examples:\n"
      "  enamel-lab operators --quick --exercise class-1-molar-46\n"
      "  enamel-lab operators --json operators.json\n"
      "The JSON: schemas/lab_operators.schema.json. Exit codes: 0 measured, 1 failed.");
  operators->callback([command, exit_code] {
    const Status status = RunOperators(*command);
    if (!status.ok()) program::SayError("operators: " + status.message());
    *exit_code = status.ok() ? 0 : 1;
  });
}

void RegisterGrades(CLI::App& app, int* exit_code) {
  auto command = std::make_shared<GradesCommand>();
  CLI::App* grades = app.add_subcommand(
      "grades", "What known faults cost: each made by formula, found by its metric, graded");
  grades->add_flag("--quick", command->options.quick, "One voxel size, one size of each fault");
  grades
      ->add_option("--exercise", command->options.exercises,
                   "Names or their beginnings (class-1, caries); else all that are built in")
      ->delimiter(',');
  grades->add_option("--voxel-um", command->voxels_um, "Voxel sizes; else 100, 50, 25")
      ->delimiter(',')
      ->check(CLI::Range(20, 400));
  grades
      ->add_option("--mixtures", command->mixtures,
                   "Instead: so many random mixtures of faults, and the laws that points obey")
      ->check(CLI::Range(1, 100'000));
  grades
      ->add_option("--offsets", command->offsets,
                   "Cut each mixture at so many more places in the grid, parts of a voxel apart")
      ->needs("--mixtures")
      ->check(CLI::Range(1, 64));
  grades->add_option("--seed", command->seed, "Of the mixtures")->capture_default_str();
  grades->add_option("--json", command->json, "Write the rows to this file");
  grades->footer(
      "Every built-in exercise at voxels of 0.1, 0.05 and 0.025 mm. The reference is the "
      "exercise's\n"
      "task taken out by formula; an attempt is the same with one fault of known size: a wall or\n"
      "floor that is off, leans or waves, a gouge, a second hole, a shaved crown, a neighbour "
      "cut,\n"
      "caries left. \"none\" is the reference itself, \"nothing\" an untouched tooth.\n"
      "  found   what the metric says; it should be the size, within a quarter of a voxel (a\n"
      "          volume: its area times that) or half a degree\n"
      "  lost    points the exercise's rubric takes for it; a critical fault takes all\n"
      "Then what all of them come to, each figure with the rows that miss it: whether the first\n"
      "mistake named is the one made, costs the points, and is critical where it should be, and\n"
      "whether every sentence said of a cut is true of its volume.\n"
      "All of it takes an hour or more; --quick a few minutes.\n"
      "\n"
      "With --mixtures, one to three faults of random kind, place and size are cut in every "
      "exercise\n"
      "in turn, then each of them larger, then one more; voxels of 0.1 mm unless --voxel-um says\n"
      "otherwise. The exercise's own rubric prices the cut: its points may not rise, the exact "
      "task\n"
      "has 100, and the points of the mistakes sum to the loss. Sentences that are false are "
      "listed.\n"
      "Examples:\n"
      "  enamel-lab grades --quick\n"
      "  enamel-lab grades --exercise class-1-molar --json grades.json\n"
      "  enamel-lab grades --mixtures 60 --seed 1\n"
      "The JSON: schemas/lab_grades.schema.json, of mixtures schemas/lab_mixtures.schema.json.\n"
      "Exit codes: 0 measured, 1 failed or a law broken.");
  grades->callback([command, exit_code] {
    if (!command->voxels_um.empty()) {
      command->options.voxels_nm.clear();
      for (int um : command->voxels_um) command->options.voxels_nm.push_back(1000 * um);
    }
    const Status status = command->mixtures > 0 ? RunMixtures(*command) : RunGrades(*command);
    if (!status.ok()) program::SayError("grades: " + status.message());
    *exit_code = status.ok() ? 0 : 1;
  });
}

}  // namespace enamel::station::lab
