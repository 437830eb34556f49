#include "server/http/wire/page_tls.h"

#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <utility>

#include "common/base/file.h"
#include "common/base/unix_time.h"
#include "common/net/certificate.h"
#include "common/net/tls.h"

namespace enamel::server::http {
namespace {

constexpr size_t kMaxPemBytes = size_t{1} << 20;
constexpr int64_t kHourMs = 3600 * 1000;
constexpr int64_t kDayMs = 24 * kHourMs;
constexpr int64_t kSoonMs = 14 * kDayMs;

}  // namespace

Result<std::unique_ptr<PageTls>> PageTls::Load(TlsFiles files) {
  std::unique_ptr<PageTls> out(new PageTls(std::move(files)));
  out->stamp_ = out->Stamp();
  ENAMEL_RETURN_IF_ERROR(out->Read());
  out->WarnOfEnd();
  return out;
}

std::string PageTls::Stamp() const {
  std::string out;
  for (const auto& file : {files_.certificate_chain, files_.private_key}) {
    struct stat found {};
    if (::stat(file.c_str(), &found) != 0) return {};
    out += std::to_string(found.st_ino) + " " + std::to_string(found.st_size) + " " +
           std::to_string(found.st_mtim.tv_sec) + "." + std::to_string(found.st_mtim.tv_nsec) + ";";
  }
  return out;
}

Status PageTls::Read() {
  ENAMEL_ASSIGN_OR_RETURN(auto context,
                          net::MakeServerContext(files_.certificate_chain, files_.private_key));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes pem, ReadFile(files_.certificate_chain, kMaxPemBytes));
  ENAMEL_ASSIGN_OR_RETURN(const net::CertificateTime time, net::CertificateTimeOf(pem));
  if (const std::string problem = net::ChainProblem(pem); !problem.empty()) {
    spdlog::warn("page: {} is not in order, and some browsers may refuse it: {}",
                 files_.certificate_chain.string(), problem);
  }
  MutexLock lock(mutex_);
  now_ = std::move(context);
  from_ms_ = time.from_ms;
  until_ms_ = time.until_ms;
  return Status::Ok();
}

void PageTls::Look() {
  // None while one of them is being replaced. Two files are not replaced at once: a certificate that
  // came before its key is refused, and taken when the key has come.
  const std::string stamp = Stamp();
  if (!stamp.empty() && stamp != stamp_) {
    stamp_ = stamp;
    if (const Status read = Read(); read.ok()) {
      spdlog::info("page: the certificate was replaced");
      warned_ = {};
    } else {
      spdlog::error("page: the new certificate cannot be used, the one before it stays: {}",
                    read.message());
    }
  }
  WarnOfEnd();
}

void PageTls::WarnOfEnd() {
  const auto now = std::chrono::steady_clock::now();
  const int64_t now_ms = UnixMs(), left_ms = until_ms() - now_ms, to_come_ms = from_ms() - now_ms;
  const bool warned =
      warned_ != std::chrono::steady_clock::time_point() && now - warned_ < std::chrono::hours(24);
  if ((left_ms > kSoonMs && to_come_ms <= 0) || warned) return;
  warned_ = now;
  if (to_come_ms > 0) {
    spdlog::error(
        "page: the certificate is not valid yet, browsers refuse it for another {:.1f} h; check "
        "this machine's clock, or use one that is valid now in {}",
        static_cast<double>(to_come_ms) / kHourMs, files_.certificate_chain.string());
  } else if (left_ms <= 0) {
    spdlog::error("page: the certificate has expired, browsers refuse it; renew {}",
                  files_.certificate_chain.string());
  } else {
    spdlog::warn("page: the certificate expires in {} days; renew {}, no restart is needed",
                 left_ms / kDayMs, files_.certificate_chain.string());
  }
}

std::shared_ptr<ssl_ctx_st> PageTls::Now() const {
  MutexLock lock(mutex_);
  return now_;
}

int64_t PageTls::from_ms() const {
  MutexLock lock(mutex_);
  return from_ms_;
}

int64_t PageTls::until_ms() const {
  MutexLock lock(mutex_);
  return until_ms_;
}

}  // namespace enamel::server::http
