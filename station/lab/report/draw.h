#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

// A report as a page to open in a browser, which the page's own components draw
// (web/scripts/report_page.mjs). Blocks for a second or two.
namespace enamel::station::lab {

// Where a report goes: the document for programs and the server, the page for people.
struct ReportFiles {
  std::filesystem::path document, page;
};
// `path` ends in .html: that page, and the document beside it. Else a folder: qualification.json
// and report.html in it.
ReportFiles ReportFilesOf(const std::filesystem::path& path);

// Whether both can be written, before a long measurement; makes the folder where `path` is one.
// `option` is what named it. Errors: kStorage.
Status CheckReport(const std::filesystem::path& path, const char* option);

// Writes `document` (with a member `report`, schemas/lab_report.schema.json) and draws it, with
// node and draw_report.mjs: installed beside the program (../share/enamel), or in the source tree
// that the program was built in. Where one of them is not there only the document is written, and
// standard error says how to draw it. Errors: kStorage; what the script says.
Status WriteReport(const std::string& document, const std::filesystem::path& path);

}  // namespace enamel::station::lab
