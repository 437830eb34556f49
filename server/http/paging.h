#pragma once

#include <algorithm>
#include <boost/json/value.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/http/message.h"

// Lists in pages (schemas/api/openapi.yaml, "Lists"): `limit` rows at most, `cursor` is the `next`
// of the page before. A cursor is the key of the last row that was given, in hexadecimal: rows that
// come or go between two pages are neither repeated nor do they push others out.
namespace enamel::server::http {

constexpr uint32_t kDefaultPage = 50;  // rows of a list whose reader says no `limit`
constexpr uint32_t kMaxPage = 200;

struct Page {
  uint32_t limit = 0;
  std::optional<std::string> after;  // key of the last row given
};
// Errors: kInvalidInput, field "limit" or "cursor".
Result<Page> PageOf(const Request& request, uint32_t otherwise, uint32_t at_most);

// `next` of an answer: null on the last page.
boost::json::value NextAfter(const std::string& key);

// Keys that sort as numbers do, and newest (largest) first.
std::string RisingKey(uint64_t number);
std::string FallingKey(uint64_t number);

// Cuts a page out of a whole list. `key`: of a row, unique. Sorts by it. Returns `next`.
template <typename Row, typename Key>
boost::json::value CutPage(std::vector<Row>& rows, const Page& page, const Key& key) {
  std::sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) { return key(a) < key(b); });
  if (page.after) std::erase_if(rows, [&](const Row& row) { return key(row) <= *page.after; });
  if (rows.size() <= page.limit) return {};
  rows.resize(page.limit);
  return NextAfter(key(rows.back()));
}

}  // namespace enamel::server::http
