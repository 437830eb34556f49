#pragma once

#include "server/storage/attempt_store.h"
#include "server/storage/audit_store.h"
#include "server/storage/batch_store.h"
#include "server/storage/content_store.h"
#include "server/storage/ingest_store.h"
#include "server/storage/job_store.h"
#include "server/storage/judging_store.h"
#include "server/storage/live_store.h"
#include "server/storage/people_store.h"
#include "server/storage/rubric_store.h"
#include "server/storage/school_store.h"
#include "server/storage/sign_in_store.h"
#include "server/storage/station_store.h"
#include "server/storage/teaching_store.h"
#include "server/storage/timeline_store.h"
#include "server/storage/upkeep_store.h"

// The one interface to everything durable; behind it SQLite or PostgreSQL (sqlite_store.h), which
// pass the same suite (tests/server/storage/backends.h). Every change is one transaction and leaves
// an audit row in the same transaction.
//
// Thread safety: any thread; calls block (one connection writes, with group commit, and a pool of
// them reads). Coroutines call it through StorePool
// (storage/store_pool.h), never directly. Errors: kNotFound, kConflict, kStorage with what to do.
namespace enamel::server {

// Who needs one subject takes its part; the whole is for who opens or hands it on.
class Store : public PeopleStore,
              public SignInStore,
              public StationStore,
              public ContentStore,
              public RubricStore,
              public TeachingStore,
              public JudgingStore,
              public IngestStore,
              public AttemptStore,
              public LiveStore,
              public JobStore,
              public BatchStore,
              public TimelineStore,
              public AuditStore,
              public SchoolStore,
              public UpkeepStore {};

}  // namespace enamel::server
