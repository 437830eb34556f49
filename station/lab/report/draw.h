#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

// A report as a page to open in a browser, which the page's own components draw
// (web/scripts/report_page.mjs). Blocks for a second or two.
namespace enamel::station::lab {

// Files of a report: the document for programs and the server, the page for people.
struct ReportFiles {
  std::filesystem::path document, page;
};
// `path` ends in .html: that page, and the document beside it. Otherwise a folder that gets
// qualification.json and report.html.
ReportFiles ReportFilesOf(const std::filesystem::path& path);

// Checks before a long measurement that both can be written; creates the folder if `path` is one.
// `option` is the option that named it. Errors: kStorage.
Status CheckReport(const std::filesystem::path& path, const char* option);

// Writes `document` (with a member `report`, schemas/lab_report.schema.json) and draws it with node
// and draw_report.mjs: installed beside the program (../share/enamel), or in the source tree that
// the program was built in. If one of them is missing only the document is written, and standard
// error says how to draw it. Errors: kStorage; the script's.
Status WriteReport(const std::string& document, const std::filesystem::path& path);

}  // namespace enamel::station::lab
