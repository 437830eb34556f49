#include "common/scene/json/text.h"

#include <algorithm>
#include <boost/json.hpp>
#include <charconv>
#include <cmath>

#include "common/base/check.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

bool IsScalar(const json::value& v) { return !v.is_object() && !v.is_array(); }

void PrintNumber(double value, std::string& out) {
  ENAMEL_CHECK(std::isfinite(value));
  char buffer[32];
  // to_chars gives the shortest text that reads back, whatever the locale. -0 is written as 0:
  // equal values must have equal bytes.
  auto end = std::to_chars(buffer, buffer + sizeof buffer, value == 0 ? 0.0 : value).ptr;
  out.append(buffer, end);
}

void PrintScalar(const json::value& v, std::string& out) {
  // Integers and texts have one spelling in Boost.JSON too; doubles have not.
  if (v.is_double()) {
    PrintNumber(v.get_double(), out);
  } else {
    out += json::serialize(v);
  }
}

void NewLine(int indent, std::string& out) {
  out += '\n';
  out.append(static_cast<size_t>(indent) * 2, ' ');
}

void Print(const json::value& v, int indent, std::string& out);

void PrintArray(const json::array& array, int indent, std::string& out) {
  // Numbers of one point on one line: documents are read by people too.
  const bool inline_items = std::all_of(array.begin(), array.end(), IsScalar);
  out += '[';
  for (size_t i = 0; i < array.size(); ++i) {
    if (i > 0) out += inline_items ? ", " : ",";
    if (!inline_items) NewLine(indent + 1, out);
    Print(array[i], indent + 1, out);
  }
  if (!inline_items) NewLine(indent, out);
  out += ']';
}

void PrintObject(const json::object& object, int indent, std::string& out) {
  out += '{';
  bool first = true;
  for (const auto& member : object) {
    if (!first) out += ',';
    first = false;
    NewLine(indent + 1, out);
    // In the order in which members were put: each document's writer fixes it.
    out += json::serialize(json::string(member.key())) + ": ";
    Print(member.value(), indent + 1, out);
  }
  if (!first) NewLine(indent, out);
  out += '}';
}

void Print(const json::value& v, int indent, std::string& out) {
  if (v.is_object()) {
    PrintObject(v.get_object(), indent, out);
  } else if (v.is_array()) {
    PrintArray(v.get_array(), indent, out);
  } else {
    PrintScalar(v, out);
  }
}

}  // namespace

std::string CanonicalText(const json::value& value) {
  std::string out;
  Print(value, 0, out);
  out += '\n';
  return out;
}

}  // namespace enamel::scene
