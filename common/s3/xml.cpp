#include "common/s3/xml.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <optional>

#include "common/base/utf8.h"

namespace enamel::s3 {
namespace {

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

// That XML 1.0 has no place for, written out or as a number.
bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 && !IsSpace(c); }

bool IsNameStart(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == ':';
}

bool IsName(char c) { return IsNameStart(c) || (c >= '0' && c <= '9') || c == '-' || c == '.'; }

void AppendUtf8(std::string& out, uint32_t code) {
  auto put = [&](uint32_t byte) { out += static_cast<char>(byte); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xc0 | code >> 6);
    put(0x80 | (code & 0x3f));
  } else if (code < 0x10000) {
    put(0xe0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3f));
    put(0x80 | (code & 0x3f));
  } else {
    put(0xf0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3f));
    put(0x80 | (code >> 6 & 0x3f));
    put(0x80 | (code & 0x3f));
  }
}

class Reader {
 public:
  Reader(std::string_view document,
         const std::function<void(const std::string&, const std::string&)>& end)
      : text_(document), end_(end) {}

  Status Run() {
    if (text_.size() > kMaxXmlBytes) return Bad("more than 4 MiB");
    if (!IsUtf8(text_)) return Bad("bytes that are no UTF-8");
    if (std::ranges::any_of(text_, IsControl)) return Bad("a control character");
    if (Take("<?xml")) {
      const size_t close = text_.find("?>", at_);
      if (close == std::string_view::npos) return Bad("a declaration without its end");
      at_ = close + 2;
    }
    SkipSpace();
    ENAMEL_RETURN_IF_ERROR(Open());
    while (!open_.empty()) ENAMEL_RETURN_IF_ERROR(Step());
    SkipSpace();
    return at_ == text_.size() ? Status::Ok() : Bad("something after its end");
  }

 private:
  struct Element {
    std::string_view name;
    size_t path = 0;  // size of path_ before it
    std::string text{};
    bool parent = false;  // has elements in it
  };

  Status Bad(const std::string& found) const {
    return Status(Code::kStorage, "expected an S3 store's XML, found " + found + " at byte " +
                                      std::to_string(at_) +
                                      "; see that the endpoint is that of an S3 store");
  }
  bool Take(std::string_view what) {
    if (!text_.substr(at_).starts_with(what)) return false;
    at_ += what.size();
    return true;
  }
  void SkipSpace() {
    while (at_ < text_.size() && IsSpace(text_[at_])) ++at_;
  }
  std::string_view Name() {
    const size_t begin = at_;
    if (at_ < text_.size() && IsNameStart(text_[at_])) {
      while (at_ < text_.size() && IsName(text_[at_])) ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }

  Status Step() {
    if (Take("</")) {
      if (Name() != open_.back().name) return Bad("the end of another element");
      SkipSpace();
      return Take(">") ? End() : Bad("an end that does not end");
    }
    if (at_ < text_.size() && text_[at_] == '<') return Open();
    return Text();
  }

  Status Open() {
    if (!Take("<")) return Bad("no element");
    const std::string_view name = Name();
    if (name.empty()) return Bad("no name of an element");
    if (open_.size() >= kMaxXmlDepth) return Bad("too many elements in each other");
    if (!open_.empty()) {
      if (open_.back().text.find_first_not_of(" \t\r\n") != std::string::npos)
        return Bad("an element beside text");
      open_.back().parent = true;
      open_.back().text.clear();
    }
    open_.push_back({name, path_.size()});
    if (!path_.empty()) path_ += '/';
    path_ += name;
    for (;;) {
      const size_t before = at_;
      SkipSpace();
      if (Take("/>")) return End();
      if (Take(">")) return Status::Ok();
      if (before == at_) return Bad("no space before an attribute");
      ENAMEL_RETURN_IF_ERROR(Attribute());
    }
  }

  Status Attribute() {
    if (Name().empty()) return Bad("no name of an attribute");
    SkipSpace();
    if (!Take("=")) return Bad("an attribute without a value");
    SkipSpace();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote != '"' && quote != '\'') return Bad("a value without quotes");
    const size_t close = text_.find(quote, at_ + 1);
    if (close == std::string_view::npos) return Bad("a value without its end");
    if (text_.substr(at_, close - at_).find('<') != std::string_view::npos)
      return Bad("an element in a value");
    at_ = close + 1;
    return Status::Ok();
  }

  Status Text() {
    if (at_ == text_.size()) return Bad("its end before that of its elements");
    Element& element = open_.back();
    if (text_[at_] == '&') {
      ENAMEL_RETURN_IF_ERROR(Entity(element.text));
    } else {
      const size_t stop = std::min(text_.find_first_of("<&", at_), text_.size());
      element.text += text_.substr(at_, stop - at_);
      at_ = stop;
    }
    if (element.text.size() > kMaxXmlText) return Bad("a text of more than 8192 bytes");
    if (!element.parent) return Status::Ok();
    if (element.text.find_first_not_of(" \t\r\n") != std::string::npos)
      return Bad("text beside elements");
    element.text.clear();
    return Status::Ok();
  }

  Status Entity(std::string& out) {
    struct Named {
      const char* text;
      char is;
    };
    for (const Named& named : {Named{"&lt;", '<'}, Named{"&gt;", '>'}, Named{"&amp;", '&'},
                               Named{"&quot;", '"'}, Named{"&apos;", '\''}}) {
      if (!Take(named.text)) continue;
      out += named.is;
      return Status::Ok();
    }
    if (!Take("&#")) return Bad("an entity that XML does not define");
    const int base = Take("x") ? 16 : 10;
    const size_t close = text_.find(';', at_);
    if (close == std::string_view::npos || close - at_ > 8) return Bad("a number without its end");
    uint32_t code = 0;
    const char* const last = text_.data() + close;
    const auto [end, bad] = std::from_chars(text_.data() + at_, last, code, base);
    const bool surrogate = code >= 0xd800 && code <= 0xdfff;
    const bool control = code < 0x20 && code != '\t' && code != '\n' && code != '\r';
    if (bad != std::errc() || end != last || code > 0x10ffff || surrogate || control)
      return Bad("the number of no character");
    AppendUtf8(out, code);
    at_ = close + 1;
    return Status::Ok();
  }

  Status End() {
    end_(path_, open_.back().text);
    path_.resize(open_.back().path);
    open_.pop_back();
    return Status::Ok();
  }

  const std::string_view text_;
  const std::function<void(const std::string&, const std::string&)>& end_;
  size_t at_ = 0;
  std::string path_;
  std::vector<Element> open_;
};

Status BadMember(const std::string& expected, const std::string& found) {
  return Status(Code::kStorage, "expected " + expected + " of an S3 store, found \"" +
                                    Printable(ShortenedText(found, 100)) +
                                    "\"; see that the endpoint is that of an S3 store");
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

Status ReadXml(std::string_view document,
               const std::function<void(const std::string& path, const std::string& text)>& end) {
  return Reader(document, end).Run();
}

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
  ListPage page;
  ListedObject object;
  Status status;
  bool is_list = false, truncated = false;
  auto note = [&](const Status& bad) {
    if (status.ok()) status = bad;
  };
  ENAMEL_RETURN_IF_ERROR(ReadXml(document, [&](const std::string& path, const std::string& text) {
    if (path == "ListBucketResult/Contents/Key") {
      object.key = text;
    } else if (path == "ListBucketResult/Contents/LastModified") {
      auto time = ReadTimeMs(text);
      if (time.ok()) object.modified_ms = *time;
      note(time.status());
    } else if (path == "ListBucketResult/Contents/Size") {
      const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), object.bytes);
      if (bad != std::errc() || end != text.data() + text.size())
        note(BadMember("the size of an object", text));
    } else if (path == "ListBucketResult/Contents") {
      if (object.key.empty()) note(BadMember("the key of an object", ""));
      page.objects.push_back(std::move(object));
      object = {};
    } else if (path == "ListBucketResult/IsTruncated") {
      truncated = text == "true";
    } else if (path == "ListBucketResult/NextContinuationToken") {
      page.next = text;
    } else if (path == "ListBucketResult") {
      is_list = true;
    }
  }));
  ENAMEL_RETURN_IF_ERROR(status);
  if (!is_list) return BadMember("ListBucketResult", std::string(document));
  if (!truncated) page.next.clear();
  if (truncated && page.next.empty())
    return BadMember("NextContinuationToken of a list that goes on", "");
  return page;
}

Result<Refusal> ReadRefusal(std::string_view document) {
  Refusal out;
  ENAMEL_RETURN_IF_ERROR(ReadXml(document, [&](const std::string& path, const std::string& text) {
    if (path == "Error/Code") out.code = text;
    if (path == "Error/Message") out.message = text;
  }));
  if (out.code.empty()) return BadMember("Error/Code", std::string(document));
  return out;
}

Result<Versioning> ReadVersioning(std::string_view document) {
  std::string state;
  bool is = false;
  ENAMEL_RETURN_IF_ERROR(ReadXml(document, [&](const std::string& path, const std::string& text) {
    if (path == "VersioningConfiguration/Status") state = text;
    if (path == "VersioningConfiguration") is = true;
  }));
  if (!is) return BadMember("VersioningConfiguration", std::string(document));
  if (state.empty()) return Versioning::kNever;
  if (state == "Enabled") return Versioning::kEnabled;
  if (state == "Suspended") return Versioning::kSuspended;
  return BadMember("Enabled or Suspended", state);
}

Result<bool> ReadObjectLock(std::string_view document) {
  std::string state;
  bool is = false;
  ENAMEL_RETURN_IF_ERROR(ReadXml(document, [&](const std::string& path, const std::string& text) {
    if (path == "ObjectLockConfiguration/ObjectLockEnabled") state = text;
    if (path == "ObjectLockConfiguration" || path == "ListBucketResult") is = true;
  }));
  if (!is) return BadMember("ObjectLockConfiguration", std::string(document));
  if (!state.empty() && state != "Enabled") return BadMember("Enabled", state);
  return !state.empty();
}

}  // namespace enamel::s3
