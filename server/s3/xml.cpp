#include "server/s3/xml.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <optional>
#include <pugixml.hpp>

#include "common/base/utf8.h"

namespace enamel::s3 {
namespace {

// That XML 1.0 does not allow. The parser would end the document at a zero byte.
bool IsControl(char c) {
  return static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r' && c != '\n';
}

Status Bad(const std::string& found) {
  return Status(Code::kStorage, "expected an S3 store's XML, found " + found +
                                    "; check that the endpoint is an S3 store");
}

Status BadMember(const std::string& expected, const std::string& found) {
  return Status(Code::kStorage, "expected " + expected + " of an S3 store, found \"" +
                                    Printable(ShortenedText(found, 100)) +
                                    "\"; check that the endpoint is an S3 store");
}

// The document's one element, kept by `tree`.
Result<pugi::xml_node> ReadRoot(std::string_view document, pugi::xml_document& tree) {
  if (document.size() > kMaxXmlBytes) return Bad("more than 4 MiB");
  if (!IsUtf8(document)) return Bad("bytes that are no UTF-8");
  if (std::ranges::any_of(document, IsControl)) return Bad("a control character");
  // A key may be one space. Document types are ignored, so they define no entities.
  const auto parsed =
      tree.load_buffer(document.data(), document.size(),
                       pugi::parse_default | pugi::parse_ws_pcdata_single, pugi::encoding_utf8);
  if (!parsed)
    return Bad(std::string(parsed.description()) + " at byte " + std::to_string(parsed.offset));
  if (tree.document_element().next_sibling()) return Bad("something after its end");
  return tree.document_element();
}

// The text of a child, empty where there is none. A character reference may be half a character.
Result<std::string> TextOf(pugi::xml_node node, const char* child) {
  std::string text = node.child_value(child);
  if (text.size() > kMaxXmlText) return Bad(std::string(child) + " of more than 8192 bytes");
  if (!IsUtf8(text)) return Bad(std::string(child) + " with bytes that are no UTF-8");
  return text;
}

Result<ListedObject> ReadObject(pugi::xml_node contents) {
  ListedObject out;
  ENAMEL_ASSIGN_OR_RETURN(out.key, TextOf(contents, "Key"));
  if (out.key.empty()) return BadMember("the key of an object", "");
  if (contents.child("LastModified")) {
    ENAMEL_ASSIGN_OR_RETURN(const std::string modified, TextOf(contents, "LastModified"));
    ENAMEL_ASSIGN_OR_RETURN(out.modified_ms, ReadTimeMs(modified));
  }
  if (contents.child("Size")) {
    ENAMEL_ASSIGN_OR_RETURN(const std::string size, TextOf(contents, "Size"));
    const auto [end, bad] = std::from_chars(size.data(), size.data() + size.size(), out.bytes);
    if (bad != std::errc() || end != size.data() + size.size())
      return BadMember("the size of an object", size);
  }
  return out;
}

std::optional<int> Digits(std::string_view text, size_t from, size_t count) {
  int out = 0;
  for (char c : text.substr(from, count)) {
    if (c < '0' || c > '9') return std::nullopt;
    out = out * 10 + (c - '0');
  }
  return out;
}

}  // namespace

Result<int64_t> ReadTimeMs(std::string_view text) {
  const Status bad = BadMember("a time like 2009-10-12T17:50:30.000Z", std::string(text));
  constexpr std::string_view kShape = "0000-00-00T00:00:00";
  if (text.size() < kShape.size() + 1 || text.size() > kShape.size() + 11 || text.back() != 'Z')
    return bad;
  for (size_t i = 0; i < kShape.size(); ++i) {
    if (kShape[i] != '0' && text[i] != kShape[i]) return bad;
  }
  int64_t ms = 0;
  const std::string_view fraction = text.substr(kShape.size(), text.size() - kShape.size() - 1);
  if (!fraction.empty()) {
    if (fraction[0] != '.' || fraction.size() < 2 || !Digits(fraction, 1, fraction.size() - 1))
      return bad;
    for (size_t i = 1; i <= 3; ++i) ms = ms * 10 + (i < fraction.size() ? fraction[i] - '0' : 0);
  }
  const auto year = Digits(text, 0, 4), month = Digits(text, 5, 2), day = Digits(text, 8, 2);
  const auto hour = Digits(text, 11, 2), minute = Digits(text, 14, 2), second = Digits(text, 17, 2);
  if (!year || !month || !day || !hour || !minute || !second) return bad;
  const std::chrono::year_month_day date(std::chrono::year(*year),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day)));
  if (!date.ok() || *hour > 23 || *minute > 59 || *second > 60) return bad;
  const int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
  return (((days * 24 + *hour) * 60 + *minute) * 60 + *second) * 1000 + ms;
}

Result<ListPage> ReadListPage(std::string_view document) {
  pugi::xml_document tree;
  ENAMEL_ASSIGN_OR_RETURN(const pugi::xml_node root, ReadRoot(document, tree));
  if (root.name() != std::string_view("ListBucketResult"))
    return BadMember("ListBucketResult", std::string(document));
  ListPage page;
  for (const pugi::xml_node contents : root.children("Contents")) {
    ENAMEL_ASSIGN_OR_RETURN(ListedObject object, ReadObject(contents));
    page.objects.push_back(std::move(object));
  }
  ENAMEL_ASSIGN_OR_RETURN(const std::string truncated, TextOf(root, "IsTruncated"));
  // XML Schema writes true and 1. Some stores print True, as Python does.
  if (truncated == "false" || truncated == "0" || truncated == "False") return page;
  if (truncated != "true" && truncated != "1" && truncated != "True")
    return BadMember("IsTruncated, true or false", truncated);
  ENAMEL_ASSIGN_OR_RETURN(page.next, TextOf(root, "NextContinuationToken"));
  if (page.next.empty()) return BadMember("NextContinuationToken of a list that continues", "");
  return page;
}

Result<Refusal> ReadRefusal(std::string_view document) {
  pugi::xml_document tree;
  ENAMEL_ASSIGN_OR_RETURN(const pugi::xml_node root, ReadRoot(document, tree));
  Refusal out;
  if (root.name() == std::string_view("Error")) {
    ENAMEL_ASSIGN_OR_RETURN(out.code, TextOf(root, "Code"));
    ENAMEL_ASSIGN_OR_RETURN(out.message, TextOf(root, "Message"));
  }
  if (out.code.empty()) return BadMember("Error/Code", std::string(document));
  return out;
}

Result<Versioning> ReadVersioning(std::string_view document) {
  pugi::xml_document tree;
  ENAMEL_ASSIGN_OR_RETURN(const pugi::xml_node root, ReadRoot(document, tree));
  if (root.name() != std::string_view("VersioningConfiguration"))
    return BadMember("VersioningConfiguration", std::string(document));
  ENAMEL_ASSIGN_OR_RETURN(const std::string state, TextOf(root, "Status"));
  if (state.empty()) return Versioning::kNever;
  if (state == "Enabled") return Versioning::kEnabled;
  if (state == "Suspended") return Versioning::kSuspended;
  return BadMember("Enabled or Suspended", state);
}

Result<bool> ReadObjectLock(std::string_view document) {
  pugi::xml_document tree;
  ENAMEL_ASSIGN_OR_RETURN(const pugi::xml_node root, ReadRoot(document, tree));
  const std::string_view name = root.name();
  if (name == "ListBucketResult") return false;
  if (name != "ObjectLockConfiguration")
    return BadMember("ObjectLockConfiguration", std::string(document));
  ENAMEL_ASSIGN_OR_RETURN(const std::string state, TextOf(root, "ObjectLockEnabled"));
  if (!state.empty() && state != "Enabled") return BadMember("Enabled", state);
  return !state.empty();
}

}  // namespace enamel::s3
