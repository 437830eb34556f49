#include "station/lab/app/reasons_command.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "common/base/file.h"
#include "common/program/log.h"
#include "common/program/output.h"
#include "station/lab/bench/bench.h"
#include "station/lab/sheet/fault_sheet.h"

namespace enamel::station::lab {
namespace {

struct ReasonsCommand {
  std::string sheet, language = "en";
};

Status RunReasons(const ReasonsCommand& command) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(command.sheet, "--sheet"));
  FaultSheetOptions options;
  if (const auto language = language::LanguageOf(command.language)) options.language = *language;
  bench::Progress progress;
  auto html = FaultSheet(options, [&](double ratio) { progress.Show("mistakes", ratio); });
  progress.Clear();
  ENAMEL_RETURN_IF_ERROR(html.status());
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(command.sheet, AsBytes(*html)));
  std::printf("%s: open it in a browser, and print it from there.\n", command.sheet.c_str());
  return Status::Ok();
}

}  // namespace

void RegisterReasons(CLI::App& app, int* exit_code) {
  auto command = std::make_shared<ReasonsCommand>();
  CLI::App* reasons = app.add_subcommand(
      "reasons", "A sheet to print: what a score says of each mistake, with a picture of it");
  reasons->add_option("--sheet", command->sheet, "Write the sheet to this HTML file")
      ->required()
      ->type_name("FILE");
  reasons->add_option("--language", command->language, "Of the sheet")
      ->check(CLI::IsMember({"en", "de", "zh"}))
      ->capture_default_str();
  reasons->footer(
      "For a dentist who checks Enamel's words before students read them. Each mistake that a "
      "score\n"
      "can name has a card: the sentence, the reason it matters, and the advice for next time. "
      "Two\n"
      "sections show the tooth as it should be and as it was cut. Many cuts are the faults of\n"
      "'enamel-lab grades'; each sentence gives what was measured on the cut in its picture. It\n"
      "takes about a minute.\n"
      "The file needs nothing beside it: no script, no network.\n"
      "Examples:\n"
      "  enamel-lab reasons --sheet reasons.html\n"
      "  enamel-lab reasons --sheet fehler.html --language de\n"
      "To change a word: schemas/words/LANGUAGE/faults.json and exercise.json (mistake*).\n"
      "Exit codes: 0 written, 1 failed.");
  reasons->callback([command, exit_code] {
    const Status status = RunReasons(*command);
    if (!status.ok()) program::SayError("reasons: " + status.message());
    *exit_code = status.ok() ? 0 : 1;
  });
}

}  // namespace enamel::station::lab
