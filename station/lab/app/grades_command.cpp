#include "station/lab/app/grades_command.h"

#include <CLI/CLI.hpp>
#include <boost/json.hpp>
#include <cstdio>
#include <memory>

#include "common/program/log.h"
#include "common/program/output.h"
#include "station/lab/bench/bench.h"
#include "station/lab/grades/grades.h"

namespace enamel::station::lab {
namespace {

struct GradesCommand {
  GradesOptions options;
  std::string json;
};

Status WriteRows(const std::string& path, const boost::json::object& document) {
  return path.empty() ? Status::Ok() : program::WriteJsonFile(path, document);
}

void PrintRow(const GradeRow& r) {
  char found[24] = "-";
  if (r.found) std::snprintf(found, sizeof found, "%.4f", *r.found);
  std::printf("%-26s %-20s %9.3f %-4s %6.3f  %-24s %9s %-3s %7.2f %7.2f\n", r.exercise.c_str(),
              r.fault.c_str(), r.size, r.unit.c_str(), r.voxel_mm, r.metric.c_str(), found,
              r.AsKnown() ? "" : "off", r.points_lost, r.score);
}

Status RunGrades(const GradesCommand& command) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(command.json, "--json"));
  bench::Progress progress;
  std::printf("%-26s %-20s %9s %-4s %6s  %-24s %9s %-3s %7s %7s\n", "exercise", "fault", "size",
              "unit", "voxel", "metric", "found", "", "lost", "score");
  size_t as_known = 0;
  auto print = [&](const GradeRow& row) {
    progress.Clear();
    PrintRow(row);
    as_known += row.AsKnown() ? 1 : 0;
  };
  ENAMEL_ASSIGN_OR_RETURN(
      const auto rows,
      MeasureGrades(command.options, print,
                    [&](const std::string& what, double ratio) { progress.Show(what, ratio); }));
  progress.Clear();
  std::printf("\n%zu of %zu faults found as they are; the others are marked \"off\".\n", as_known,
              rows.size());
  return WriteRows(command.json, GradesJson(rows));
}

}  // namespace

void RegisterGrades(CLI::App& app, int* exit_code) {
  auto command = std::make_shared<GradesCommand>();
  CLI::App* grades = app.add_subcommand(
      "grades", "What known faults cost: each made by formula, found by its metric, graded");
  grades->add_flag("--quick", command->options.quick, "One voxel size, one size of each fault");
  grades
      ->add_option("--exercise", command->options.exercises,
                   "Names or their beginnings (class-1, caries); else all that are built in")
      ->delimiter(',');
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
      "All of it takes an hour or more; --quick a few minutes.\n"
      "Examples:\n"
      "  enamel-lab grades --quick\n"
      "  enamel-lab grades --exercise class-1-molar --json grades.json\n"
      "The JSON: schemas/lab_grades.schema.json. Exit codes: 0 measured, 1 failed.");
  grades->callback([command, exit_code] {
    const Status status = RunGrades(*command);
    if (!status.ok()) program::SayError("grades: " + status.message());
    *exit_code = status.ok() ? 0 : 1;
  });
}

}  // namespace enamel::station::lab
