#include "server/live/board_keeper.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "common/base/stoppable_sleep.h"
#include "common/base/unix_time.h"

namespace enamel::server {
namespace {

constexpr UnixMs kFreshMs = 60'000;

}  // namespace

BoardKeeper::BoardKeeper(StationBoard& board, Store& store, bool shared)
    : board_(board),
      store_(store),
      shared_(shared),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void BoardKeeper::Run(const std::stop_token& stop) {
  int looks = 0;
  do {
    LookAtRemarks(enamel::UnixMs());
    if (shared_ && looks++ % kLinksEvery == 0) LookAtLinks();
  } while (!SleepUntilStopped(stop, kLookEvery));
}

void BoardKeeper::LookAtRemarks(UnixMs now_ms) {
  RemarkBoard& remarks = board_.remarks();
  if (const auto moved = remarks.Moved(); !moved.empty()) {
    if (!store_.live.MoveRemarks(moved).ok()) return;
    remarks.Stored(moved);
  }
  // A server that is alone hears of each remark itself, but for those from before it began.
  if (!shared_ && remarks_read_) return;
  const auto all = store_.live.ChairRemarks(now_ms - kRemarksForMs);
  if (!all.ok()) return;
  std::set<Uuid> attempts;
  for (const ChairRemark& remark : *all) {
    remarks.Put(remark);
    attempts.insert(remark.attempt);
  }
  // Drops remarks of attempts sealed at another server, but none that came during this read.
  remarks.KeepOnly(attempts, now_ms - kFreshMs);
  remarks_read_ = true;
}

void BoardKeeper::LookAtLinks() {
  Status kept = KeepLinks();
  if (kept.code() == Code::kNotFound) {
    kept_.reset();
    kept = KeepLinks();
  }
  if (!kept.ok()) return;
  if (const auto elsewhere = store_.live.LinksElsewhere(); elsewhere.ok()) {
    board_.SetElsewhere(*elsewhere);
  }
}

Status BoardKeeper::KeepLinks() {
  const std::vector<StationLink> here = board_.Here();
  const std::vector<StationLink> before = kept_.value_or(std::vector<StationLink>());
  std::vector<StationLink> come;
  std::ranges::copy_if(here, std::back_inserter(come), [&](const StationLink& link) {
    const auto at = std::ranges::lower_bound(before, link.station, {}, &StationLink::station);
    return at == before.end() || *at != link;
  });
  std::vector<Uuid> gone;
  for (const StationLink& link : before) {
    if (!std::ranges::binary_search(here, link.station, {}, &StationLink::station)) {
      gone.push_back(link.station);
    }
  }
  ENAMEL_RETURN_IF_ERROR(store_.live.KeepLinks(come, gone, !kept_));
  kept_ = here;
  return Status::Ok();
}

}  // namespace enamel::server
