#pragma once

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "common/base/file.h"
#include "common/net/certificate.h"
#include "common/net/tls.h"
#include "common/protocol/attempt_facts.h"
#include "common/protocol/frame.h"
#include "common/protocol/messages.h"
#include "common/protocol/refusals.h"
#include "common/protocol/remark.h"
#include "station/uplink/credentials.h"
#include "tests/support/read_message.h"

namespace enamel::station {

namespace asio = boost::asio;

// A header that can be decoded, of an attempt of this person.
inline trace::Header HeaderOf(const Uuid& person) {
  trace::Header header;
  header.ticket.attempt = Uuid::New();
  header.ticket.person = person;
  header.params.rate_hz = 1000;
  header.params.kc_mn_per_mm = 2500;
  header.params.resolution_nm = {10'000, 10'000, 10'000};
  header.params.peak_force_mn = 7900;
  header.params.bur_radius_nm = 500'000;
  header.hand.kind = HandKind::kProgram;
  return header;
}

// The server's half of the station link, over real TLS on loopback, with a store in memory and
// faults on demand. A thread for each connection.
class FakeServer {
 public:
  explicit FakeServer(const std::filesystem::path& folder, uint16_t port = 0)
      : pem_(folder / "server.pem"), key_(folder / "server.key") {
    if (!std::filesystem::exists(pem_)) {
      ENAMEL_CHECK(net::CreateCertificateFiles(pem_, key_, "enamel-test").ok());
    }
    context_ = *net::MakeServerContext(pem_, key_);
    asio::ip::tcp::endpoint at(asio::ip::address_v4::loopback(), port);
    acceptor_.open(at.protocol());
    acceptor_.set_option(asio::socket_base::reuse_address(true));
    acceptor_.bind(at);
    acceptor_.listen();
    thread_ = std::thread([this] { Run(); });
  }
  ~FakeServer() {
    stopping_ = true;
    asio::io_context io;
    asio::ip::tcp::socket wake(io);
    boost::system::error_code ignored;
    wake.connect(acceptor_.local_endpoint(), ignored);
    thread_.join();
    Break();
    for (std::thread& connection : threads_) connection.join();
  }

  net::Endpoint endpoint() const { return {"127.0.0.1", acceptor_.local_endpoint().port()}; }
  Sha256 fingerprint() const { return *net::CertificateFingerprint(*ReadFile(pem_)); }
  Credentials NewStation() const {
    Credentials c;
    c.server = endpoint();
    c.fingerprint = fingerprint();
    c.station = Uuid::New();
    c.secret_key = trace::NewKeyPair().secret_key;
    return c;
  }

  // The stored part of the first attempt.
  std::map<uint32_t, Bytes> chunks() const {
    std::lock_guard lock(mutex_);
    auto at = chunks_.find(first_);
    return at == chunks_.end() ? std::map<uint32_t, Bytes>{} : at->second;
  }
  bool sealed() const { return sealed_; }
  int connections() const { return connections_; }
  int doubled() const { return doubled_; }  // chunks it was sent although it had them
  void Forget(uint32_t from) {
    std::lock_guard lock(mutex_);
    for (auto& [attempt, chunks] : chunks_) chunks.erase(chunks.lower_bound(from), chunks.end());
  }

  // Closes the connection instead of acknowledging the n-th chunk from now on (and each n-th
  // after).
  std::atomic<int> break_every{0};
  std::atomic<bool> watched{false};  // says so with every answer about an attempt
  std::atomic<int> ack_delay_ms{0};
  std::atomic<bool> revoke_tickets{false};  // all that it is offered
  int live() const { return live_; }        // LiveStates that came
  uint64_t last_live_tick() const { return last_live_tick_; }
  int offered() const { return offered_; }       // attempts
  uint32_t resumed() const { return resumed_; }  // as the last OpenAttempt said

  // A message to the chair, sent with every acknowledgement and answer to a ping until it was
  // shown.
  void Say(const protocol::Remark& remark) {
    std::lock_guard lock(mutex_);
    remarks_.push_back(remark);
  }
  uint64_t shown() const { return shown_; }              // highest id that a station named
  bool shows_remarks() const { return shows_remarks_; }  // as the last Hello said

  // Accepts requests and answers none, like a server that hangs.
  std::atomic<bool> silent{false};
  std::atomic<int> unanswered{0};

  // How many StillWaiting it sends before it answers.
  std::atomic<int> still_waiting{0};

  // The person who signs in, for any login.
  Uuid person = Uuid::New();
  // The password is for one use, until ChoosePassword replaces it.
  std::string role = "student";  // of whoever signs in
  std::atomic<bool> must_change_password{false};
  // What ChoosePassword is refused with; set it before one comes.
  std::optional<Status> refuse_passwords;
  // The last that came. Read it after the answer.
  const wire::ChoosePassword& password_choice() const { return password_choice_; }
  // What sign-ins are refused with.
  std::optional<Status> refuse_sign_ins;
  // Exercises in the list, one entry for each; zero: none.
  std::vector<Uuid> assignments;
  // Fills in the entry of that place in the list.
  std::function<void(size_t, wire::ExerciseRef&)> describe;
  // Device profiles of the list: their names, and hashes of the documents.
  std::vector<std::pair<std::string, Sha256>> profiles;
  // The last request for a ticket; all are refused. Read it after the answer.
  const wire::RequestTicket& asked_for() const { return asked_for_; }

  // Answers OpenAttempt and ReturnTicket with this. ReturnTicket also while it runs, between two
  // requests.
  std::optional<Status> refuse, refuse_returns;
  // The attempt with this header has to wait for data that a restore has removed.
  std::optional<Bytes> awaits;
  // Attempts whose tickets were returned, each time.
  std::vector<Uuid> returned() const {
    std::lock_guard lock(mutex_);
    return returned_;
  }
  // Signatures that came, and what they are refused with; set it before they come.
  std::vector<wire::SignOff> sign_offs() const {
    std::lock_guard lock(mutex_);
    return sign_offs_;
  }
  std::optional<Status> refuse_sign_offs;
  void SetPageUrl(std::string url) {
    std::lock_guard lock(mutex_);
    page_url_ = std::move(url);
  }
  // The settings that it gives a station.
  void Set(const std::string& name, const std::string& value, bool fixed) {
    std::lock_guard lock(mutex_);
    wire::Setting& setting = *policy_.add_settings();
    setting.set_name(name);
    setting.set_value(value);
    setting.set_fixed(fixed);
  }
  // Attempts visible to the person who signs in. Not while it answers.
  std::set<Uuid> seen;
  // The score of those that it sees, as JSON; empty: not scored yet.
  std::string result_json;

 private:
  wire::RequestTicket asked_for_;
  wire::ChoosePassword password_choice_;
  using Stream = asio::ssl::stream<asio::ip::tcp::socket>;
  void Break() {
    std::lock_guard lock(mutex_);
    for (int connection : open_) ::shutdown(connection, SHUT_RDWR);
  }

  void Run() {
    while (!stopping_) {
      asio::ip::tcp::socket socket = acceptor_.accept();
      if (stopping_) return;
      ++connections_;
      std::lock_guard lock(mutex_);
      open_.insert(socket.native_handle());
      threads_.emplace_back([this, s = std::move(socket)]() mutable { Serve(std::move(s)); });
    }
  }

  void Serve(asio::ip::tcp::socket socket) {
    const int fd = socket.native_handle();
    Stream stream(std::move(socket), SSL_new(context_.get()));
    try {
      stream.handshake(Stream::server);
      while (!stopping_) {
        auto request = protocol::ParseRequest(test::ReadMessage(stream));
        if (silent && (request->has_sign_in() || request->has_list_exercises() ||
                       request->has_attempt_status())) {
          ++unanswered;
          continue;
        }
        for (int i = 0; i < still_waiting; ++i) {
          wire::Reply reply;
          reply.set_reply_to(request->id());
          reply.mutable_still_waiting();
          asio::write(stream, asio::buffer(*protocol::EncodeFrame(protocol::Serialize(reply))));
        }
        Answer(stream, *request);
      }
    } catch (const boost::system::system_error&) {
      // The station disconnected, or a fault was requested.
    }
    std::lock_guard lock(mutex_);
    open_.erase(fd);
    boost::system::error_code ignored;
    stream.next_layer().close(ignored);
  }

  void Answer(Stream& stream, const wire::Request& request) {
    wire::Reply reply;
    reply.set_reply_to(request.id());
    if (request.has_hello()) {
      reply.mutable_welcome()->set_core_version(request.hello().core_version());
      shows_remarks_ = request.hello().shows_remarks();
      {
        std::lock_guard lock(mutex_);
        reply.mutable_welcome()->set_page_url(page_url_);
        *reply.mutable_welcome()->mutable_policy() = policy_;
      }
    } else if (request.has_open_attempt()) {
      if (refuse) {
        *reply.mutable_error() = protocol::ToError(*refuse);
      } else if (awaits && request.open_attempt().header() == protocol::ToField(*awaits)) {
        *reply.mutable_error() = protocol::ToError(
            Status(Code::kUnavailable, "person 7 is not here", protocol::kAwaited));
      } else {
        std::lock_guard lock(mutex_);
        auto header = trace::DecodeHeader(AsBytes(request.open_attempt().header()));
        ENAMEL_CHECK(header.ok());
        if (chunks_.empty()) first_ = header->ticket.attempt;
        auto& chunks = chunks_[header->ticket.attempt];
        uint32_t next = 0;
        while (chunks.count(next) != 0) ++next;
        resumed_ = request.open_attempt().facts().resumed();
        reply.mutable_attempt_opened()->set_next_seq(next);
        reply.mutable_attempt_opened()->set_watched(watched);
      }
    } else if (request.has_offer_attempts()) {
      std::lock_guard lock(mutex_);
      offered_ += request.offer_attempts().attempts_size();
      auto& wanted = *reply.mutable_attempts_wanted();
      for (const auto& held : request.offer_attempts().attempts()) {
        auto at = chunks_.find(*protocol::ReadUuid(held.attempt(), "attempt"));
        bool whole = at != chunks_.end() && at->second.size() == held.chunks();
        if (!whole) wanted.add_attempts(held.attempt());
      }
      for (const auto& ticket : request.offer_attempts().tickets()) {
        if (revoke_tickets) wanted.add_revoked(ticket);
      }
    } else if (request.has_attempt_status()) {
      if (seen.contains(*protocol::ReadUuid(request.attempt_status().attempt(), "attempt"))) {
        reply.mutable_attempt_state()->set_state(result_json.empty() ? "ticketed" : "scored");
        reply.mutable_attempt_state()->set_result_json(result_json);
      } else {
        *reply.mutable_error() = protocol::ToError(Status(Code::kNotFound, "no such attempt"));
      }
    } else if (request.has_return_ticket()) {
      std::lock_guard lock(mutex_);
      returned_.push_back(*protocol::ReadUuid(request.return_ticket().attempt(), "attempt"));
      if (refuse_returns) {
        *reply.mutable_error() = protocol::ToError(*refuse_returns);
      } else {
        *reply.mutable_ticket_returned() = {};
      }
    } else if (request.has_sign_off()) {
      std::lock_guard lock(mutex_);
      sign_offs_.push_back(request.sign_off());
      if (refuse_sign_offs) {
        *reply.mutable_error() = protocol::ToError(*refuse_sign_offs);
      } else {
        reply.mutable_signed_off()->set_display_name("Ada");
      }
    } else if (request.has_live_state()) {
      ++live_;
      last_live_tick_ = request.live_state().tick();
      return;
    } else if (request.has_sign_in() && refuse_sign_ins) {
      *reply.mutable_error() = protocol::ToError(*refuse_sign_ins);
    } else if (request.has_choose_password() && refuse_passwords) {
      *reply.mutable_error() = protocol::ToError(*refuse_passwords);
    } else if (request.has_sign_in() || request.has_choose_password()) {
      if (request.has_choose_password()) {
        password_choice_ = request.choose_password();
        must_change_password = false;
      }
      wire::SignedIn& in = *reply.mutable_signed_in();
      in.set_person_id(protocol::ToField(person.view()));
      in.set_role(role);
      in.set_session(must_change_password ? "once" : "own");
      in.set_must_change_password(must_change_password);
    } else if (request.has_list_exercises()) {
      for (const Uuid& assignment : assignments) {
        wire::ExerciseRef& ref = *reply.mutable_exercises()->add_exercises();
        ref.set_title("Exercise " + std::to_string(reply.exercises().exercises_size()));
        for (auto* hash : {ref.mutable_exercise(), ref.mutable_scene(), ref.mutable_volume()}) {
          *hash = protocol::ToField(Sha256{}.view());
        }
        if (!assignment.IsZero()) ref.set_assignment(protocol::ToField(assignment.view()));
        if (describe) describe(static_cast<size_t>(&assignment - assignments.data()), ref);
      }
      for (const auto& [name, hash] : profiles) {
        wire::ProfileRef& ref = *reply.mutable_exercises()->add_profiles();
        ref.set_name(name);
        ref.set_profile(protocol::ToField(hash.view()));
      }
      reply.mutable_exercises();
    } else if (request.has_request_ticket()) {
      asked_for_ = request.request_ticket();
      *reply.mutable_error() = protocol::ToError(Status(Code::kForbidden, "no tickets here"));
    } else if (request.has_ping()) {
      AddRemarks(request.ping().shown_remark(), *reply.mutable_pong()->mutable_remarks());
    } else if (request.has_put_chunk()) {
      Keep(request.put_chunk(), reply);
    } else if (request.has_seal_attempt()) {
      sealed_ = true;
      reply.mutable_sealed();
    } else {
      *reply.mutable_error() = protocol::UnsupportedError();
    }
    asio::write(stream, asio::buffer(*protocol::EncodeFrame(protocol::Serialize(reply))));
  }

  void Keep(const wire::PutChunk& put, wire::Reply& reply) {
    ByteView bytes = AsBytes(put.chunk());
    auto chunk = trace::DecodeChunk(bytes);
    ENAMEL_CHECK(chunk.ok());
    {
      std::lock_guard lock(mutex_);
      auto& chunks = chunks_[chunk->head.attempt];
      doubled_ += chunks.count(chunk->head.seq) != 0 ? 1 : 0;
      chunks[chunk->head.seq] = Bytes(bytes.begin(), bytes.end());
    }
    // Stored, but without an acknowledgement to the station.
    if (break_every != 0 && ++received_ % break_every == 0) {
      throw boost::system::system_error(asio::error::connection_reset);
    }
    if (ack_delay_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(ack_delay_ms));
    reply.mutable_chunk_ack()->set_watched(watched);
    reply.mutable_chunk_ack()->set_attempt(protocol::ToField(chunk->head.attempt.view()));
    reply.mutable_chunk_ack()->set_seq(chunk->head.seq);
    reply.mutable_chunk_ack()->set_committed(true);
    AddRemarks(put.shown_remark(), *reply.mutable_chunk_ack()->mutable_remarks());
  }

  void AddRemarks(uint64_t shown, google::protobuf::RepeatedPtrField<wire::Remark>& out) {
    shown_ = std::max(shown_.load(), shown);
    std::lock_guard lock(mutex_);
    for (const protocol::Remark& remark : remarks_) {
      if (remark.id > shown_) protocol::SetRemark(remark, *out.Add());
    }
  }

  std::filesystem::path pem_, key_;
  std::shared_ptr<SSL_CTX> context_;
  asio::io_context io_;
  asio::ip::tcp::acceptor acceptor_{io_};
  std::vector<std::thread> threads_;  // one each; of thread_
  std::thread thread_;
  std::atomic<bool> stopping_{false}, sealed_{false};
  std::atomic<int> connections_{0}, doubled_{0}, live_{0}, offered_{0};
  std::atomic<uint64_t> last_live_tick_{0};
  std::atomic<uint32_t> resumed_{0};
  std::atomic<int> received_{0};
  std::atomic<uint64_t> shown_{0};
  std::atomic<bool> shows_remarks_{false};
  mutable std::mutex mutex_;
  std::set<int> open_;                                // guarded by mutex_
  Uuid first_;                                        // guarded by mutex_
  std::string page_url_;                              // guarded by mutex_
  wire::Policy policy_;                               // guarded by mutex_
  std::vector<Uuid> returned_;                        // guarded by mutex_
  std::vector<wire::SignOff> sign_offs_;              // guarded by mutex_
  std::vector<protocol::Remark> remarks_;             // guarded by mutex_
  std::map<Uuid, std::map<uint32_t, Bytes>> chunks_;  // guarded by mutex_
};

}  // namespace enamel::station
