#pragma once

#include <array>
#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/auth/authenticator.h"
#include "server/auth/first_admin.h"
#include "server/http/message.h"
#include "server/http/request_places.h"
#include "server/http/routes.h"
#include "server/http/shared_bodies.h"
#include "server/jobs/backup_run.h"
#include "server/storage/store.h"
#include "server/storage/store_pool.h"

namespace enamel::server::http {

// From request to answer, without a socket: route, same-site check, session, role, CSRF, handler,
// in this order. Thread safety: Handle from any strand; the work itself runs on the store's
// threads, so no I/O thread ever blocks. At most `max_in_flight` requests wait for those threads;
// more get 503. Changes have threads of their own, and so has health: reads continue while changes wait.
//
// Threads, requests and the bytes of large answers are shared out to people, and to addresses where
// nobody is signed in: one of them has half of the threads at most, and takes turns with the others.
//
// A request that waits for longer than `work` gets 503. If a thread has begun it by then, the work
// finishes, keeps its place among `max_in_flight` and its answer is dropped; otherwise it is not
// done. Held by shared_ptr: such work keeps the Api.
class Api : public std::enable_shared_from_this<Api> {
 public:
  Api(Store& store, auth::Authenticator& authenticator, Monitoring monitoring, size_t threads,
      size_t max_in_flight, std::chrono::milliseconds work = std::chrono::seconds(60),
      const ops::Budgets& budgets = {});

  // Attempts can be watched from now on. Before the first Handle.
  void Show(LiveBoard& live) { live_ = &live; }
  // The first admin can be made from now on. Before the first Handle.
  void Show(auth::FirstAdmin& first_admin) { first_admin_ = &first_admin; }
  // Which stations are connected is known from now on. Before the first Handle.
  void Show(StationBoard& stations) { stations_ = &stations; }
  // Allows stations to enrol from now on, with the fingerprint that they check. Before the first
  // Handle.
  void Enrol(std::string station_fingerprint) {
    station_fingerprint_ = std::move(station_fingerprint);
  }
  // Where backups go that people start. Before the first Handle.
  void BackUpInto(BackupRun::Place place) { backups_->Into(std::move(place)); }
  // The stations' port, once it is known.
  void StationsListenAt(uint16_t port) { station_port_ = port; }
  // GET /readyz says from now on that others shall be asked. From any thread.
  void Drain() { draining_ = true; }
  // Whether whoever asked for the events may still see them; on the store's threads.
  boost::asio::awaitable<bool> StillAllowed(EventSource& events);
  // On a thread that may block.
  boost::asio::awaitable<Result<Bytes>> NextPiece(const BytePieces& body);

  // True for paths that are never the page's.
  static bool Owns(std::string_view path);

  // Requires: what runs it is a strand, or one thread.
  boost::asio::awaitable<Response> Handle(Request request);

  // Waits until the store's threads have finished their work: afterwards nothing of ours uses the
  // store. Requires: no Handle runs any more.
  void EndWork();

  // Answers, sign-ins, reads and budgets.
  void AddFigures(ops::MetricsText& text) const;
  // Returns the use of each budget: by people and stations of this school, and by addresses.
  std::vector<ops::BudgetUse> Budgets() const;

 private:
  struct Work;
  boost::asio::awaitable<Response> AnswerInTime(Request request);
  boost::asio::awaitable<void> Do(std::shared_ptr<Work> work);
  boost::asio::awaitable<Response> Answer(const Request& request);
  boost::asio::awaitable<Response> Asynchronous(Call& call, const Route& route, std::string of);
  Response Blocking(Call& call, const Route& route);
  Result<auth::Identity> Identify(const Request& request);
  void NoteForbidden(const Call& call, const Route& route, const Response& response);

  Store& store_;
  auth::Authenticator& authenticator_;
  const Monitoring monitoring_;
  const size_t max_in_flight_;
  const std::chrono::milliseconds work_;
  const ops::Budgets budgets_;
  LiveBoard* live_ = nullptr;
  auth::FirstAdmin* first_admin_ = nullptr;
  StationBoard* stations_ = nullptr;
  std::string station_fingerprint_;
  std::atomic<uint16_t> station_port_{0};
  std::atomic<bool> draining_{false};
  std::atomic<size_t> in_flight_{0};
  RequestPlaces places_;
  SharedBodies bodies_;
  HeldBytes unsent_;
  LiveCuts cuts_;
  std::array<std::atomic<uint64_t>, 6> answers_{};
  std::atomic<uint64_t> forbidden_{0};
  Histogram reads_;
  std::optional<StorePool> pool_;  // until EndWork
  // Until EndWork. Apart from reads: changes may wait for the database.
  std::optional<StorePool> changes_;
  std::optional<StorePool> apart_{std::in_place, 1};  // until EndWork
  std::optional<ToothImport> teeth_;                  // until EndWork
  std::optional<BackupRun> backups_;                  // until EndWork
  std::optional<ExerciseTrials> trials_;              // until EndWork
};

}  // namespace enamel::server::http
