#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/mutex.h"
#include "server/http/wire/http_server.h"
#include "server/stations/station_server.h"
#include "server/storage/people/school_list.h"
#include "server/storage/store.h"

namespace enamel::server::app {

class School;

// The other schools of an installation, as one of its servers serves them. Reads the installation's
// list now and then, and opens and closes changed schools. If a school's store cannot be opened, it
// tries again; the other schools are not affected.
//
// A closed school is destroyed once nobody uses it: whoever answers for it holds it. Thread safety:
// any thread. Lifetime: the store outlives this; this outlives doors that ask it. Destruction waits
// until all schools have ended, so nobody may hold one then.
class Schools final : public stations::OtherSchools {
 public:
  static constexpr std::chrono::milliseconds kLookEvery{2000};

  // Opens a school: with its doors, but not begun. On this object's thread.
  struct Opened {
    std::shared_ptr<School> school;
    std::shared_ptr<http::Api> api;
  };
  using Open = std::function<Result<Opened>(const SchoolRow& row)>;
  // Its folder can go from this machine: it was deleted.
  using Forget = std::function<void(const std::string& name)>;

  // `store`: the installation's own, which has the list.
  Schools(Store& store, Open open, Forget forget);
  ~Schools() override;

  // Reads the list, then opens the schools one after another on a thread of its own, which keeps
  // watching for changes. Once.
  void Begin();
  // As HttpServer::Drain, of all of them.
  void Drain();

  // For HttpOptions::other_schools.
  std::optional<http::OtherSchool> AtHost(const std::string& host);
  Result<std::shared_ptr<stations::Services>> ServicesOf(const wire::Request& first) override;
  std::vector<std::shared_ptr<stations::Services>> All() override;
  // Nobody waits for another process's work from now on (Store::StopWaiting).
  void StopWaiting();

 private:
  struct Served {
    SchoolRow row;
    std::shared_ptr<School> school;  // null: it is not served, or not opened yet
    std::shared_ptr<http::Api> api;
    std::weak_ptr<School> before;  // ended, and somebody is at it still
    std::string problem{};         // why it could not be opened
  };
  void Run(const std::stop_token& stop);
  void Look(const std::stop_token& stop);
  // Afterwards every listed school is known, and removed ones have ended.
  void Read();
  // Returns the school that was served, for the caller to end.
  static std::shared_ptr<School> LetGo(Served& served);
  // Opens it, where it is to be served and is not.
  void OpenOne(const std::string& name);
  Result<Opened> TryToOpen(const SchoolRow& row);
  void EndThose();
  std::vector<Served> Listed() const;

  Store& store_;
  const Open open_;
  const Forget forget_;
  mutable Mutex mutex_;
  bool read_ ENAMEL_GUARDED_BY(mutex_) = false;  // the list, once
  bool draining_ ENAMEL_GUARDED_BY(mutex_) = false;
  std::map<std::string, Served> served_ ENAMEL_GUARDED_BY(mutex_);  // what is listed
  // No longer listed, and forgotten once nobody is at them.
  std::map<std::string, std::weak_ptr<School>> gone_ ENAMEL_GUARDED_BY(mutex_);
  // Closed, and no longer held by anybody: the end of a school waits for its threads, so this
  // object's thread does that waiting.
  struct Ended;
  const std::shared_ptr<Ended> ended_;
  std::jthread thread_;  // last: ends first
};

}  // namespace enamel::server::app
