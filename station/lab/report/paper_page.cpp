#include "station/lab/report/paper_page.h"

#include <algorithm>
#include <boost/json.hpp>
#include <vector>

#include "station/lab/suites/findings.h"

namespace enamel::station::lab {
namespace {

constexpr PaperVerdict kVerdicts[] = {PaperVerdict::kReproduced, PaperVerdict::kRemark,
                                      PaperVerdict::kContradicts, PaperVerdict::kNotReproducible};

std::string Counts(std::span<const PaperElement> elements) {
  std::string out;
  for (PaperVerdict verdict : kVerdicts) {
    const auto n = std::count_if(elements.begin(), elements.end(),
                                 [&](const PaperElement& e) { return e.verdict == verdict; });
    out += (out.empty() ? "" : ", ") + std::to_string(n) + " " + NameOf(verdict);
  }
  return out;
}

bool Is(const PaperElement& e, const std::string& kind) { return e.element.starts_with(kind); }

// A bar would end the cell of a table.
std::string Cell(std::string text) {
  for (size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2)
    text.insert(at, "\\");
  return text;
}

std::string MarkdownRow(const std::vector<std::string>& cells) {
  std::string out = "|";
  for (const std::string& c : cells) out += " " + Cell(c) + " |";
  return out + "\n";
}

std::string Remarks(std::span<const PaperElement> elements, const std::string& kind) {
  std::string out;
  for (const PaperElement& e : elements) {
    if (!Is(e, kind)) continue;
    std::string line;
    if (!e.how.empty()) line += " How: " + e.how + ".";
    if (!e.remark.empty()) line += " " + e.remark;
    if (!line.empty()) out += "* **" + e.element + ".**" + line + "\n";
  }
  return out + "\n";
}

std::string AsList(std::span<const PaperElement> elements, const std::string& kind,
                   const std::string& title) {
  std::string out = "## " + title + "\n\n" +
                    MarkdownRow({"", "what it says", "printed", "ours", "verdict"}) +
                    "|---|---|---|---|---|\n";
  for (const PaperElement& e : elements) {
    if (Is(e, kind)) out += MarkdownRow({e.element, e.says, e.printed, e.ours, NameOf(e.verdict)});
  }
  return out + "\n" + Remarks(elements, kind);
}

std::string AsTable(const PrintedPaper& p, std::span<const PaperElement> elements, int number) {
  const std::string kind = "table " + std::to_string(number) + ",";
  std::vector<std::string> head = {""}, resolution = {"position resolution, mm"},
                           stiffness = {number == 3 ? "Kc, N/mm"
                                                    : "maximum achievable stiffness, N/mm"},
                           rate = {"sampling frequency, Hz"}, printed = {"**printed**"},
                           ours = {"**ours**"}, verdict = {"verdict"};
  std::string says;
  for (const PrintedDevice& d : p.devices) {
    head.push_back(d.name);
    resolution.push_back(F(d.resolution_mm, "%.3f"));
    stiffness.push_back(F(number == 3 ? d.table3_kc_n_per_mm : d.max_stiffness_n_per_mm, "%.3g"));
    rate.push_back(F(d.rate_hz, "%.0f"));
  }
  for (const PaperElement& e : elements) {
    if (!Is(e, kind)) continue;
    says = e.says;
    printed.push_back(e.printed);
    ours.push_back(e.ours);
    verdict.push_back(NameOf(e.verdict));
  }
  std::string out = "## Table " + std::to_string(number) + ": " + says + "\n\n" +
                    MarkdownRow(head) + "|---|---|---|---|\n";
  for (const auto& row : {resolution, stiffness, rate, printed, ours, verdict})
    out += MarkdownRow(row);
  return out + "\n" + Remarks(elements, kind);
}

}  // namespace

std::string PaperText(std::span<const PaperElement> elements) {
  std::string out;
  for (const PaperElement& e : elements) {
    out += e.element + ": " + e.says + "\n";
    auto Line = [&](const char* name, const std::string& text) {
      if (!text.empty()) out += std::string("  ") + name + text + "\n";
    };
    Line("printed  ", e.printed);
    Line("ours     ", e.ours);
    Line("how      ", e.how);
    Line("verdict  ", NameOf(e.verdict));
    Line("remark   ", e.remark);
    Line("command  ", e.command);
    out += "\n";
  }
  return out + std::to_string(elements.size()) + " elements: " + Counts(elements) + ".\n";
}

std::string PaperMarkdown(const PrintedPaper& printed, std::span<const PaperElement> elements) {
  std::string out =
      "# The paper beside ours\n\n"
      "Enamel's force began with one paper:\n\n"
      "> G. Liu, Y. Zhang, D. Wang, W. T. Townsend. *Stable haptic interaction using a damping "
      "model to implement a\n"
      "> realistic tooth-cutting simulation for dental training.* Virtual Reality 12 (2008) "
      "99–106.\n"
      "> [doi:10.1007/s10055-008-0094-x](https://doi.org/10.1007/s10055-008-0094-x)\n\n"
      "This page has each of its equations, tables and figures, what is printed there, what we "
      "find, and a verdict.\n"
      "`enamel-lab paper` computes it in some seconds, and `enamel-lab paper --markdown "
      "docs/paper.md` writes this page.\n"
      "A test compares the two.\n\n";
  out += std::to_string(elements.size()) + " elements: " + Counts(elements) + ".\n\n";
  out +=
      "Symbols: B damping of the tissue, V speed, p position, delta the encoder's resolution, f "
      "the sampling frequency,\n"
      "T = 1/f, K the largest stiffness of the device, Kc that of the limiter, a acceleration. A "
      "force is the resistance\n"
      "that the hand meets: positive against its motion. The paper prints B negative; here it is "
      "positive.\n\n";
  out += AsList(elements, "measured", "The measured cutting");
  out += AsList(elements, "equation", "Equations");
  for (int table : {1, 2, 3}) out += AsTable(printed, elements, table);
  out += AsList(elements, "figure", "Figures");
  out +=
      "More of the same experiments, with other laws and other readings of eq. 17:\n"
      "`enamel-lab qualify --profile all --suite paper --report paper.html`.\n";
  return out;
}

boost::json::object PaperJson(std::span<const PaperElement> elements) {
  boost::json::array rows;
  for (const PaperElement& e : elements) {
    rows.push_back(boost::json::object{{"element", e.element},
                                       {"says", e.says},
                                       {"printed", e.printed},
                                       {"ours", e.ours},
                                       {"how", e.how},
                                       {"verdict", NameOf(e.verdict)},
                                       {"remark", e.remark},
                                       {"command", e.command}});
  }
  return {{"format", 1},
          {"citation",
           "Liu, Zhang, Wang, Townsend, Virtual Reality 12 (2008) 99-106, "
           "doi:10.1007/s10055-008-0094-x"},
          {"rows", std::move(rows)}};
}

}  // namespace enamel::station::lab
