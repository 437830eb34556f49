#pragma once

#include <concepts>
#include <tuple>

#include "server/storage/store.h"

namespace enamel::server {

// Some parts of the store, for who touches more than one; who touches one takes it by reference.
// Made of anything that is all of them: the whole store, wider parts, a test's double.
//   Result<Cut> Read(Parts<AttemptStore, ContentStore> store) {
//     … store.attempts().ResultOf(id) … store.content().GetBlob(hash) …
// Refers to the store and is copied cheaply. Thread safety: the store's.
template <typename... P>
class Parts {
  template <typename Q>
  static constexpr bool kHas = (std::derived_from<P, Q> || ...);

 public:
  template <typename Whole>
  requires(std::derived_from<Whole, P>&&...) Parts(Whole& whole)
      : parts_(&static_cast<P&>(whole)...) {}
  template <typename... Q>
  requires(std::convertible_to<const Parts<Q...>&, P&>&&...) Parts(const Parts<Q...>& wider)
      : parts_(&static_cast<P&>(wider)...) {}

  template <typename Q>
  requires kHas<Q>
  operator Q&() const {
    Q* found = nullptr;
    auto look = [&found](auto* part) {
      if constexpr (std::convertible_to<decltype(part), Q*>) found = part;
    };
    std::apply([&look](auto*... part) { (look(part), ...); }, parts_);
    return *found;
  }

  PeopleStore& people() const requires kHas<PeopleStore> { return *this; }
  SignInStore& sign_ins() const requires kHas<SignInStore> { return *this; }
  StationStore& stations() const requires kHas<StationStore> { return *this; }
  BlobStore& blobs() const requires kHas<BlobStore> { return *this; }
  ContentStore& content() const requires kHas<ContentStore> { return *this; }
  TeachingStore& teaching() const requires kHas<TeachingStore> { return *this; }
  RubricStore& rubrics() const requires kHas<RubricStore> { return *this; }
  ReferenceStore& references() const requires kHas<ReferenceStore> { return *this; }
  JudgingStore& judging() const requires kHas<JudgingStore> { return *this; }
  IngestStore& ingest() const requires kHas<IngestStore> { return *this; }
  AttemptStore& attempts() const requires kHas<AttemptStore> { return *this; }
  LiveStore& live() const requires kHas<LiveStore> { return *this; }
  JobStore& jobs() const requires kHas<JobStore> { return *this; }
  TimelineStore& timelines() const requires kHas<TimelineStore> { return *this; }
  BatchStore& batches() const requires kHas<BatchStore> { return *this; }
  AuditStore& audit() const requires kHas<AuditStore> { return *this; }
  SchoolStore& schools() const requires kHas<SchoolStore> { return *this; }
  UpkeepStore& upkeep() const requires kHas<UpkeepStore> { return *this; }

 private:
  std::tuple<P*...> parts_;
};

}  // namespace enamel::server
