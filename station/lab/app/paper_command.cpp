#include "station/lab/app/paper_command.h"

#include <CLI/CLI.hpp>
#include <boost/json.hpp>
#include <cstdio>
#include <memory>

#include "common/base/file.h"
#include "common/program/log.h"
#include "common/program/output.h"
#include "station/lab/report/paper_page.h"

namespace enamel::station::lab {
namespace {

struct PaperCommand {
  std::string element, json, markdown;
};

Status RunPaper(const PaperCommand& command) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(command.json, "--json"));
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(command.markdown, "--markdown"));
  const PrintedPaper printed;
  const std::vector<PaperElement> all = PaperElements(printed);
  std::vector<PaperElement> shown;
  for (const PaperElement& e : all) {
    // "table 1" is all of table 1, "equation 1" not equation 10.
    const bool whole = e.element == command.element || e.element.starts_with(command.element + ",");
    if (command.element.empty() || whole) shown.push_back(e);
  }
  if (shown.empty()) {
    return {Code::kInvalidInput,
            "expected an element of the paper, as \"equation 16\", \"table 3\", \"figure 8\" or "
            "\"measured "
            "cutting\", found \"" +
                command.element + "\"",
            "element"};
  }
  std::fputs(PaperText(shown).c_str(), stdout);
  if (!command.markdown.empty()) {
    const std::string page = PaperMarkdown(printed, all);
    ENAMEL_RETURN_IF_ERROR(WriteFileDurably(command.markdown, AsBytes(page)));
  }
  return command.json.empty() ? Status::Ok()
                              : program::WriteJsonFile(command.json, PaperJson(shown));
}

}  // namespace

void RegisterPaper(CLI::App& app, int* exit_code) {
  auto command = std::make_shared<PaperCommand>();
  CLI::App* paper = app.add_subcommand(
      "paper", "Every equation, table and figure of Liu et al. 2008 beside ours, with a verdict");
  paper->add_option("element", command->element,
                    "One of them, as \"equation 16\" or \"table 3\"; else all thirty");
  paper->add_option("--json", command->json,
                    "Write the rows to this file (schemas/lab_paper.schema.json)");
  paper->add_option("--markdown", command->markdown,
                    "Write the page to this file, as docs/paper.md");
  paper->footer(
      "The paper: G. Liu, Y. Zhang, D. Wang, W. T. Townsend, Virtual Reality 12 (2008) 99-106,\n"
      "doi:10.1007/s10055-008-0094-x. Each verdict is computed from what is printed and what is "
      "found:\n"
      "  reproduced\n"
      "  reproduced with a remark\n"
      "  contradicts itself                      the remark has the derivation\n"
      "  not reproducible from what is printed   the remark says what is missing\n"
      "Examples:\n"
      "  enamel-lab paper\n"
      "  enamel-lab paper \"table 3\"\n"
      "  enamel-lab paper --json paper.json\n"
      "Exit codes: 0 done, 1 failed.");
  paper->callback([command, exit_code] {
    const Status status = RunPaper(*command);
    if (!status.ok()) program::SayError("paper: " + status.message());
    *exit_code = status.ok() ? 0 : 1;
  });
}

}  // namespace enamel::station::lab
