#include "server/agreement/marks.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "common/base/csv.h"
#include "server/agreement/figure_json.h"
#include "server/agreement/standard.h"

namespace enamel::server {
namespace {

namespace json = boost::json;

enum Column { kWork, kCriterion, kMarker, kMark, kFullMarks, kColumns };
constexpr std::array<std::string_view, kColumns> kNames = {"work", "criterion", "marker", "mark",
                                                           "full_marks"};
constexpr std::array<size_t, 3> kMaxBytes = {100, 200, 100};

Status Wrong(uint32_t row, const std::string& expected, const std::string& found) {
  return Status(Code::kInvalidInput,
                "row " + std::to_string(row) + ": expected " + expected + ", found " +
                    (found.empty() ? "nothing" : found),
                "row " + std::to_string(row));
}

// The index of each column; -1: missing.
Result<std::array<int, kColumns>> Columns(const CsvRow& header) {
  std::array<int, kColumns> places;
  places.fill(-1);
  for (size_t i = 0; i < header.cells.size(); ++i) {
    auto name = std::ranges::find(kNames, header.cells[i]);
    if (name == kNames.end() || places[name - kNames.begin()] >= 0) {
      return Wrong(header.row, "the columns work, criterion, marker, mark (and full_marks), once",
                   "\"" + header.cells[i] + "\"");
    }
    places[name - kNames.begin()] = static_cast<int>(i);
  }
  for (int i = 0; i < kFullMarks; ++i) {
    if (places[i] < 0) return Wrong(header.row, "a column " + std::string(kNames[i]), "");
  }
  return places;
}

Result<double> PointsOf(const CsvRow& row, const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || !std::isfinite(value)) {
    return Wrong(row.row, "a number as mark (with a point, not a comma)", "\"" + text + "\"");
  }
  return value;
}

// A slip of the pen, 75 for 7.5, would be read as a disagreement. Where the column has no number,
// nothing is known of how much there was to earn.
Status CheckRange(const CsvRow& row, double points, const std::string& full_marks) {
  const Result<double> full = PointsOf(row, full_marks);
  if (!full.ok() || (points >= 0 && points <= *full)) return Status::Ok();
  return Wrong(row.row, "a mark from 0 to the full marks, " + full_marks, std::to_string(points));
}

// The marks of one criterion: a row for each piece of work, a column for each marker.
struct Marked {
  std::map<std::string, std::map<std::string, double>> by_work;
  std::set<std::string> markers;
};

// Whole marks as classes; none where some mark is not whole or there are too many.
std::optional<std::vector<double>> ClassesOf(const MarkTable& table) {
  std::set<double> found;
  for (const auto& row : table) {
    for (double mark : row) {
      if (mark != std::floor(mark)) return std::nullopt;
      found.insert(mark);
    }
  }
  if (found.size() > kMaxClasses) return std::nullopt;
  return std::vector<double>(found.begin(), found.end());
}

size_t ClassOf(const std::vector<double>& classes, double mark) {
  return std::ranges::lower_bound(classes, mark) - classes.begin();
}

void FillKappas(const MarkTable& table, CriterionAgreement& out) {
  const auto classes = ClassesOf(table);
  if (!classes || classes->size() < 2) {
    const std::string why =
        classes ? "all marks are the same" : "kappa is for whole marks in at most 20 classes";
    out.weighted_kappa = out.free_kappa = {std::nullopt, why};
    return;
  }
  const size_t q = classes->size();
  std::vector<std::vector<double>> by_pair(q, std::vector<double>(q)), by_work;
  // Weights by the marks and not by their place in the list: 2 and 9 are farther apart than 8 and
  // 9, whatever lies between.
  std::vector<std::vector<double>> weights(q, std::vector<double>(q));
  for (size_t i = 0; i < q; ++i) {
    for (size_t j = 0; j < q; ++j) weights[i][j] = std::pow((*classes)[i] - (*classes)[j], 2);
  }
  for (const auto& row : table) {
    std::vector<double> counts(q);
    for (double mark : row) counts[ClassOf(*classes, mark)] += 1;
    by_work.push_back(std::move(counts));
    if (row.size() == 2) by_pair[ClassOf(*classes, row[0])][ClassOf(*classes, row[1])] += 1;
  }
  out.free_kappa = FigureOf(FreeMarginalKappa(by_work));
  out.weighted_kappa = out.markers.size() == 2
                           ? FigureOf(WeightedKappa(by_pair, weights))
                           : Figure{std::nullopt, "weighted kappa is for two markers"};
}

// A row for each piece of work that all of them marked, a column for each of them.
MarkTable TableOf(const Marked& marked, const std::vector<std::string>& markers, size_t& left_out) {
  std::vector<std::vector<std::optional<double>>> rows;
  for (const auto& [work, marks] : marked.by_work) {
    std::vector<std::optional<double>> row;
    for (const std::string& marker : markers) {
      auto found = marks.find(marker);
      row.push_back(found == marks.end() ? std::nullopt : std::optional(found->second));
    }
    const bool anybody =
        std::ranges::any_of(row, [](const auto& mark) { return mark.has_value(); });
    if (anybody) rows.push_back(std::move(row));
  }
  MarkTable table = CompleteRows(rows);
  left_out = rows.size() - table.size();
  return table;
}

PairLimits LimitsOf(const MarkTable& table, const std::vector<std::string>& markers, size_t i,
                    size_t j) {
  std::vector<double> first, second;
  for (const auto& row : table) {
    first.push_back(row[i]);
    second.push_back(row[j]);
  }
  PairLimits out{markers[i], markers[j], std::nullopt, ""};
  auto limits = BlandAltman(first, second);
  if (limits.ok()) {
    out.limits = *limits;
  } else {
    out.why = limits.status().message();
  }
  return out;
}

// What the program does not share with people would be taken for their disagreement.
void CompareWithProgram(const Marked& marked, CriterionAgreement& out) {
  std::vector<std::string> all = out.markers;
  all.emplace_back(kComputed);
  size_t left_out = 0;
  const MarkTable table = TableOf(marked, all, left_out);
  out.computed = true;
  out.computed_works = table.size();
  MarkTable two;
  for (const auto& row : table) {
    double sum = 0;
    for (size_t i = 0; i + 1 < row.size(); ++i) sum += row[i];
    two.push_back({sum / static_cast<double>(row.size() - 1), row.back()});
  }
  out.computed_icc21 = FigureOf(Icc21(two));
  for (size_t i = 0; i + 1 < all.size(); ++i) {
    out.limits.push_back(LimitsOf(table, all, i, all.size() - 1));
  }
}

void CompareWithEachOther(const MarkTable& table, CriterionAgreement& out) {
  out.icc21 = FigureOf(Icc21(table));
  out.icc3k = FigureOf(Icc3k(table));
  out.phi = FigureOf(Dependability(table));
  FillKappas(table, out);
  for (size_t i = 0; i < out.markers.size(); ++i) {
    for (size_t j = i + 1; j < out.markers.size(); ++j) {
      out.limits.push_back(LimitsOf(table, out.markers, i, j));
    }
  }
}

CriterionAgreement Compare(const std::string& criterion, const Marked& marked) {
  CriterionAgreement out;
  out.criterion = criterion;
  for (const std::string& marker : marked.markers) {
    if (marker != kComputed) out.markers.push_back(marker);
  }
  const bool has_people = !out.markers.empty();
  if (out.markers.size() < 2) out.why = SecondMarkerNeeded(out.markers);
  if (!has_people) out.markers.emplace_back(kComputed);
  const MarkTable table = TableOf(marked, out.markers, out.left_out);
  out.works = table.size();
  if (out.why.empty()) CompareWithEachOther(table, out);
  if (has_people && marked.markers.contains(std::string(kComputed)))
    CompareWithProgram(marked, out);
  return out;
}

std::string NumberText(double value) {
  std::array<char, 32> text{};
  auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, 4);
  return std::string(text.data(), end);
}

}  // namespace

std::string SecondMarkerNeeded(const std::vector<std::string>& people) {
  if (people.empty()) {
    return "agreement needs two markers, as nobody marked this: let two people mark the same work, "
           "without seeing each other's marks, and compare both";
  }
  return "agreement needs a second marker, as only " + people.front() +
         " marked this: let another person mark the same work, without seeing these marks, and "
         "compare both";
}

Figure FigureOf(const Result<Agreement>& result) {
  if (result.ok()) return {*result, ""};
  return {std::nullopt, result.status().message()};
}

json::object FigureJson(const Agreement& a) {
  return {{"value", a.value}, {"low", a.interval.low}, {"high", a.interval.high}};
}

json::object FigureJson(const Figure& f) {
  if (f.value) return FigureJson(*f.value);
  return {{"value", nullptr}, {"why", f.why}};
}

Result<std::vector<Mark>> ReadMarks(std::string_view csv) {
  if (csv.size() > kMaxMarksBytes) {
    return Status(Code::kTooLarge, "expected at most 4 MiB of marks");
  }
  const CsvTable table = ReadCsv(csv, {kMaxMarkRows + 1, 16, 1000});
  ENAMEL_RETURN_IF_ERROR(table.status());
  if (table.rows.empty()) return Wrong(1, "a header: work,criterion,marker,mark", "");
  ENAMEL_ASSIGN_OR_RETURN(const auto places, Columns(table.rows.front()));
  std::vector<Mark> out;
  for (size_t i = 1; i < table.rows.size(); ++i) {
    const CsvRow& row = table.rows[i];
    auto cell = [&](Column column) {
      const auto place = static_cast<size_t>(places[column]);
      return place < row.cells.size() ? row.cells[place] : std::string();
    };
    // A mark with a comma would be read as a smaller one and a cell too many.
    const size_t columns = table.rows.front().cells.size();
    if (std::any_of(
            row.cells.begin() + static_cast<std::ptrdiff_t>(std::min(columns, row.cells.size())),
            row.cells.end(), [](const std::string& extra) { return !extra.empty(); })) {
      return Wrong(row.row,
                   std::to_string(columns) +
                       " cells, as the header has (a number with a point, not a comma)",
                   std::to_string(row.cells.size()));
    }
    if (cell(kMark).empty()) continue;
    Mark mark{cell(kWork), cell(kCriterion), cell(kMarker), 0, {}};
    const std::array<const std::string*, 3> texts = {&mark.work, &mark.criterion, &mark.marker};
    for (size_t t = 0; t < texts.size(); ++t) {
      if (!texts[t]->empty() && texts[t]->size() <= kMaxBytes[t]) continue;
      return Wrong(row.row,
                   std::string(kNames[t]) + " of 1 to " + std::to_string(kMaxBytes[t]) + " bytes",
                   std::to_string(texts[t]->size()) + " bytes");
    }
    ENAMEL_ASSIGN_OR_RETURN(mark.points, PointsOf(row, cell(kMark)));
    ENAMEL_RETURN_IF_ERROR(CheckRange(row, mark.points, cell(kFullMarks)));
    if (const auto full = PointsOf(row, cell(kFullMarks)); full.ok()) mark.full_marks = *full;
    out.push_back(std::move(mark));
  }
  return out;
}

Result<std::vector<CriterionAgreement>> CompareMarks(const std::vector<Mark>& marks) {
  if (marks.empty()) return Status(Code::kInvalidInput, "expected marks, found none");
  // What examiners say of a student who is just good enough is no marked work.
  std::map<std::string, Marked> by_criterion, of_borderline;
  for (const Mark& mark : marks) {
    Marked& marked = (mark.work == kBorderlineWork ? of_borderline : by_criterion)[mark.criterion];
    marked.markers.insert(mark.marker);
    if (!marked.by_work[mark.work].emplace(mark.marker, mark.points).second) {
      return Status(Code::kInvalidInput, mark.marker + " marked " + mark.work + " twice for \"" +
                                             mark.criterion + "\"; expected one mark");
    }
  }
  std::vector<CriterionAgreement> out;
  for (const auto& [criterion, marked] : by_criterion) out.push_back(Compare(criterion, marked));
  return out;
}

std::string AgreementJson(const std::vector<CriterionAgreement>& criteria) {
  json::array list;
  for (const CriterionAgreement& c : criteria) {
    json::array markers(c.markers.begin(), c.markers.end()), limits;
    for (const PairLimits& pair : c.limits) {
      json::object row{{"first", pair.first}, {"second", pair.second}};
      if (pair.limits) {
        row["bias"] = FigureJson(pair.limits->bias);
        row["low_limit"] = FigureJson(pair.limits->low);
        row["high_limit"] = FigureJson(pair.limits->high);
      } else {
        row["why"] = pair.why;
      }
      limits.push_back(std::move(row));
    }
    json::object row{{"criterion", c.criterion},
                     {"markers", std::move(markers)},
                     {"works", c.works},
                     {"left_out", c.left_out},
                     {"limits_of_agreement", std::move(limits)}};
    if (c.why.empty()) {
      row["icc_2_1"] = FigureJson(c.icc21);
      row["icc_3_k"] = FigureJson(c.icc3k);
      row["phi"] = FigureJson(c.phi);
      row["weighted_kappa"] = FigureJson(c.weighted_kappa);
      row["free_kappa"] = FigureJson(c.free_kappa);
    } else {
      row["why"] = c.why;
    }
    if (c.computed) {
      row["computed"] = {{"works", c.computed_works},
                         {"icc_2_1_with_mean", FigureJson(c.computed_icc21)}};
    }
    list.push_back(std::move(row));
  }
  return json::serialize(json::object{{"criteria", std::move(list)}}) + "\n";
}

std::string AgreementCsv(const std::vector<CriterionAgreement>& criteria) {
  std::string out =
      CsvLine({"criterion", "figure", "first", "second", "value", "low", "high", "works", "why"});
  for (const CriterionAgreement& c : criteria) {
    const std::string works = std::to_string(c.works);
    auto add = [&](std::string_view figure, const std::string& first, const std::string& second,
                   const std::optional<Agreement>& value, const std::string& why) {
      out += CsvLine({c.criterion, figure, first, second, value ? NumberText(value->value) : "",
                      value ? NumberText(value->interval.low) : "",
                      value ? NumberText(value->interval.high) : "", works, why});
    };
    if (c.why.empty()) {
      add("ICC(2,1)", "", "", c.icc21.value, c.icc21.why);
      add("ICC(3,k)", "", "", c.icc3k.value, c.icc3k.why);
      add("phi", "", "", c.phi.value, c.phi.why);
      add("weighted kappa", "", "", c.weighted_kappa.value, c.weighted_kappa.why);
      add("free-marginal kappa", "", "", c.free_kappa.value, c.free_kappa.why);
    } else {
      add("agreement", c.markers.front(), "", std::nullopt, c.why);
    }
    if (c.computed) {
      add("ICC(2,1)", "mean", std::string(kComputed), c.computed_icc21.value, c.computed_icc21.why);
    }
    for (const PairLimits& pair : c.limits) {
      if (!pair.limits) {
        add("bias", pair.first, pair.second, std::nullopt, pair.why);
        continue;
      }
      add("bias", pair.first, pair.second, pair.limits->bias, "");
      add("low limit of agreement", pair.first, pair.second, pair.limits->low, "");
      add("high limit of agreement", pair.first, pair.second, pair.limits->high, "");
    }
  }
  return out;
}

}  // namespace enamel::server
