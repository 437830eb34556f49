#pragma once

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string_view>
#include <utility>

#include "common/scoring/score.h"

// What the writer and the reader of a stored score share (schemas/score.md); for score_json.cpp and
// score_read.cpp only.
namespace enamel::scoring::stored {

inline constexpr double kMPerMm = 1e-3, kM3PerMm3 = 1e-9;

// To 12 significant digits: more than any metric means, and few enough that every reader of decimal
// text gives back the same double.
inline double Rounded(double value) {
  char text[40];
  auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 12).ptr;
  double out = value;
  std::from_chars(text, end, out);
  return out;
}

template <typename T>
using Name = std::pair<T, std::string_view>;
inline constexpr Name<NoValue> kWhy[] = {{NoValue::kNotInTask, "not_in_task"},
                                         {NoValue::kNotMade, "not_made"},
                                         {NoValue::kNotUsed, "not_used"}};
inline constexpr Name<Acceptance> kAcceptances[] = {{Acceptance::kAcceptable, "acceptable"},
                                                    {Acceptance::kWithRemarks, "with_remarks"},
                                                    {Acceptance::kNotAcceptable, "not_acceptable"}};
// Whether the dearer side of a region is what was cut too far.
inline constexpr Name<bool> kSides[] = {{true, "over"}, {false, "left"}};
template <typename T, size_t kCount>
std::string_view NameOf(const Name<T> (&names)[kCount], T value) {
  return std::ranges::find(names, value, &Name<T>::first)->second;
}

}  // namespace enamel::scoring::stored
