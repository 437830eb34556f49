#pragma once

#include <boost/json/fwd.hpp>
#include <span>
#include <string>

#include "station/lab/suites/paper_elements.h"

// "The paper beside ours" for the terminal, for docs/paper.md and as rows (schemas/lab_paper.schema.json). Pure.
namespace enamel::station::lab {

// A block an element, and how many have which verdict.
std::string PaperText(std::span<const PaperElement> elements);
// Tables 1 to 3 in the paper's layout: a device a column. Requires: all of PaperElements(printed).
std::string PaperMarkdown(const PrintedPaper& printed, std::span<const PaperElement> elements);
boost::json::object PaperJson(std::span<const PaperElement> elements);

}  // namespace enamel::station::lab
