#include "server/http/static_files.h"

#include <algorithm>
#include <utility>

#include "common/base/bytes.h"
#include "common/base/file.h"
#include "common/base/sha256.h"
#include "server/http/error_response.h"

namespace enamel::server::http {
namespace {

namespace fs = std::filesystem;

// The page is a few MiB. A wrong --web, such as a home folder, is refused instead of read into
// memory.
constexpr size_t kMaxTogether = size_t{64} << 20;
constexpr size_t kHashLength = 8;  // esbuild's [hash]

constexpr std::pair<std::string_view, std::string_view> kContentTypes[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".map", "application/json"},
    {".webmanifest", "application/manifest+json"},
    {".ftl", "text/plain; charset=utf-8"},
    {".txt", "text/plain; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".jpg", "image/jpeg"},
    {".webp", "image/webp"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".wasm", "application/wasm"},
};

std::string ContentType(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  for (const auto& [known, type] : kContentTypes) {
    if (extension == known) return std::string(type);
  }
  return "application/octet-stream";
}

bool HasHashedName(const std::string& path) {
  std::string stem = fs::path(path).stem().string();
  size_t dash = stem.rfind('-');
  if (dash == std::string::npos || stem.size() - dash - 1 < kHashLength) return false;
  return std::all_of(stem.begin() + static_cast<std::ptrdiff_t>(dash) + 1, stem.end(),
                     [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); });
}

std::string CacheControl(const std::string& path) {
  // It names the other files by their hashes: kept, it would name those of an older page.
  if (path.ends_with("/index.html")) return "no-store";
  return HasHashedName(path) ? "public, max-age=31536000, immutable" : "no-cache";
}

// True for paths of the page's own router: plain words, no file.
bool LooksLikePageAddress(std::string_view path) {
  return std::all_of(path.begin(), path.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '/';
  });
}

bool StripSuffix(std::string& text, std::string_view suffix) {
  if (!text.ends_with(suffix)) return false;
  text.resize(text.size() - suffix.size());
  return true;
}

}  // namespace

bool Accepts(std::string_view list, std::string_view coding) {
  while (!list.empty()) {
    size_t end = std::min(list.find(','), list.size());
    std::string item(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
    item.erase(std::remove(item.begin(), item.end(), ' '), item.end());
    if (item.substr(0, item.find(';')) != coding) continue;
    size_t q = item.find(";q=");
    return q == std::string::npos || item.find_first_of("123456789", q) != std::string::npos;
  }
  return false;
}

Result<StaticFiles> StaticFiles::Load(const fs::path& folder) {
  StaticFiles out;
  std::error_code error;
  size_t together = 0;
  fs::recursive_directory_iterator walk(folder, error), end;
  for (; !error && walk != end; walk.increment(error)) {
    // A link could lead out of the folder. All files are read now and none later: no request's path
    // ever reaches the file system.
    if (walk->is_symlink(error) || !walk->is_regular_file(error)) continue;
    ENAMEL_ASSIGN_OR_RETURN(Bytes bytes, ReadFile(walk->path(), kMaxTogether));
    together += bytes.size();
    if (together > kMaxTogether) {
      return Status{Code::kTooLarge, "expected a page of at most 64 MiB in " + folder.string() +
                                         ", found more; is this the page's dist folder?"};
    }
    auto content = std::make_shared<const std::string>(AsText(bytes));
    std::string path = fs::relative(walk->path(), folder, error).generic_string();
    path.insert(path.begin(), '/');
    if (StripSuffix(path, ".br")) {
      out.files_[path].br = std::move(content);
    } else if (StripSuffix(path, ".gz")) {
      out.files_[path].gz = std::move(content);
    } else {
      out.files_[path].plain = std::move(content);
    }
  }
  // A packed file without its original could be given to browsers that take it and to no others.
  std::erase_if(out.files_, [](const auto& entry) { return !entry.second.plain; });
  for (auto& [path, file] : out.files_) {
    file.content_type = ContentType(path);
    file.cache_control = CacheControl(path);
    // 128 bits: nobody has two files that agree in them by chance.
    file.etag = HashSha256(AsBytes(*file.plain)).Hex().substr(0, 32);
  }
  if (!out.files_.contains("/index.html")) {
    return Status{Code::kNotFound, "expected the built page (index.html) in " + folder.string() +
                                       ", found none; build the page or name its dist folder"};
  }
  return out;
}

const StaticFiles::File* StaticFiles::Find(std::string_view path) const {
  if (auto found = files_.find(path); found != files_.end()) return &found->second;
  if (!LooksLikePageAddress(path)) return nullptr;
  // The page's own router then finds the view, or says that there is none.
  for (size_t end = path.rfind('/'); end != std::string_view::npos && end > 0;
       end = path.rfind('/', end - 1)) {
    const auto nearest = files_.find(std::string(path.substr(0, end)) + "/index.html");
    if (nearest != files_.end()) return &nearest->second;
  }
  return &files_.find("/index.html")->second;
}

Response StaticFiles::Serve(const Request& request) const {
  if (request.method != Method::kGet && request.method != Method::kHead) {
    Response refused =
        ErrorResponse(405, "method_not_allowed", "expected GET or HEAD for the page");
    refused.headers.emplace_back("Allow", "GET, HEAD");
    return refused;
  }
  const File* file = Find(request.path);
  if (!file)
    return ErrorResponse(404, "not_found", "expected a file of the page, found none of this name");

  Response response;
  response.content_type = file->content_type;
  response.shared_body = file->plain;
  std::string tag = '"' + file->etag;
  std::string_view accepted = request.Header("accept-encoding");
  if (file->br && Accepts(accepted, "br")) {
    response.shared_body = file->br;
    response.headers.emplace_back("Content-Encoding", "br");
    tag += "-br";
  } else if (file->gz && Accepts(accepted, "gzip")) {
    response.shared_body = file->gz;
    response.headers.emplace_back("Content-Encoding", "gzip");
    tag += "-gz";
  }
  // Also with the uncompressed file: a cache in between must not give a compressed one to a client
  // that cannot unpack it.
  if (file->br || file->gz) response.headers.emplace_back("Vary", "Accept-Encoding");
  response.headers.emplace_back("Cache-Control", file->cache_control);
  if (file->cache_control == "no-store") return response;
  tag += '"';
  response.headers.emplace_back("ETag", tag);
  if (request.Header("if-none-match").find(tag) != std::string_view::npos) {
    response.status = 304;
    response.content_type.clear();
    response.shared_body = nullptr;
  }
  return response;
}

}  // namespace enamel::server::http
