#pragma once

#include <boost/json/value.hpp>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"

// Strict reading of the documents we author: every member must be known, present, of its type and
// in its range. The first thing wrong is kept, with its JSON pointer ("/tissues/0/provenance");
// after it every read returns a harmless default, so that a reader is one straight run and one
// check.
namespace enamel::scene {

// Parses text of at most 1 MiB and depth 16. Errors: kTooLarge, kInvalidInput (with the offset),
// also for a member that appears twice.
Result<boost::json::value> ParseBounded(std::string_view text);

// One JSON object being read. Thread safety: none. `status` must outlive it.
class ObjectReader {
 public:
  ObjectReader(const boost::json::value& value, std::string path, Status& status);

  // Inclusive range.
  int64_t Int(std::string_view name, int64_t lo, int64_t hi);
  double Number(std::string_view name, double lo, double hi);
  bool Bool(std::string_view name);
  // Length in bytes of UTF-8.
  std::string Text(std::string_view name, size_t min_size, size_t max_size);
  // Lower-case letters, digits, '-' and '_', 1 to 64 of them.
  std::string Name(std::string_view name);
  Sha256 Hash(std::string_view name);
  // 1 to `max_count` names, each as Name reads one.
  std::vector<std::string> NameList(std::string_view name, size_t max_count);
  // Exactly `size` integers.
  std::vector<int32_t> Ints(std::string_view name, size_t size, int32_t lo, int32_t hi);
  // Exactly `size` finite numbers per row.
  std::vector<std::vector<double>> Rows(std::string_view name, size_t size, size_t max_rows);
  ObjectReader Object(std::string_view name);
  std::vector<ObjectReader> Objects(std::string_view name, size_t min_count, size_t max_count);
  bool Has(std::string_view name) const;
  // Names of all members, for objects that are maps.
  std::vector<std::string> Names() const;

  // Member `kind` ("enamel_scene") says what the document is and which format of it: 1. Another
  // format is kVersion, and so is a document of an earlier Enamel, which has "format" instead.
  void Format(std::string_view kind);
  // Refuses members nobody asked for. Call last.
  void Finish();
  // Records that member `name` is wrong, unless something was wrong before.
  void Refuse(std::string_view name, const std::string& expected, const std::string& found);

 private:
  const boost::json::value* Take(std::string_view name);
  std::string PathOf(std::string_view name) const { return path_ + "/" + std::string(name); }

  const boost::json::object* object_ = nullptr;
  std::string path_;
  Status* status_;
  std::set<std::string, std::less<>> taken_;
};

}  // namespace enamel::scene
