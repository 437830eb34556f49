#include <string>

#include "common/base/check.h"
#include "common/base/utf8.h"
#include "server/s3/xml.h"

namespace {

std::string Escaped(const std::string& text) {
  std::string out;
  for (unsigned char c : text) {
    // A line end written as a number would be read as a plain one.
    if (c < 0x20 || c == '<' || c == '&') {
      out += "&#" + std::to_string(c) + ";";
    } else {
      out += static_cast<char>(c);
    }
  }
  return out;
}

}  // namespace

// Answers of an S3 store, or of something in its place. An accepted list is within its bounds, and
// reads the same after being written again.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel::s3;
  const std::string_view document(reinterpret_cast<const char*>(data), size);
  if (const auto page = ReadListPage(document); page.ok()) {
    std::string again = "<ListBucketResult>";
    for (const ListedObject& object : page->objects) {
      ENAMEL_CHECK(!object.key.empty() && object.key.size() <= kMaxXmlText);
      ENAMEL_CHECK(enamel::IsUtf8(object.key));
      again += "<Contents><Key>" + Escaped(object.key) + "</Key><Size>" +
               std::to_string(object.bytes) + "</Size></Contents>";
    }
    if (!page->next.empty()) {
      again += "<IsTruncated>true</IsTruncated><NextContinuationToken>" + Escaped(page->next) +
               "</NextContinuationToken>";
    }
    again += "</ListBucketResult>";
    if (again.size() <= kMaxXmlBytes) {
      const auto read = ReadListPage(again);
      ENAMEL_CHECK(read.ok() && read->objects.size() == page->objects.size());
      ENAMEL_CHECK(read->next == page->next);
      for (size_t i = 0; i < read->objects.size(); ++i) {
        ENAMEL_CHECK(read->objects[i].key == page->objects[i].key);
        ENAMEL_CHECK(read->objects[i].bytes == page->objects[i].bytes);
      }
    }
  }
  if (const auto refusal = ReadRefusal(document); refusal.ok())
    ENAMEL_CHECK(!refusal->code.empty());
  (void)ReadVersioning(document).ok();
  (void)ReadObjectLock(document).ok();
  return 0;
}
