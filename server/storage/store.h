#pragma once

#include <memory>

#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/attempts/job_rows.h"
#include "server/storage/attempts/live_rows.h"
#include "server/storage/attempts/remark_rows.h"
#include "server/storage/audit/audit_rows.h"
#include "server/storage/engine/database_look.h"
#include "server/storage/engine/server_identity.h"
#include "server/storage/judging/appeal_rows.h"
#include "server/storage/judging/batch_rows.h"
#include "server/storage/judging/judging_rows.h"
#include "server/storage/judging/marking_rows.h"
#include "server/storage/judging/motion_rows.h"
#include "server/storage/judging/reference_rows.h"
#include "server/storage/judging/result_rows.h"
#include "server/storage/judging/timeline_rows.h"
#include "server/storage/people/cohort_rows.h"
#include "server/storage/people/device_rows.h"
#include "server/storage/people/people_rows.h"
#include "server/storage/people/roster_rows.h"
#include "server/storage/people/saved_text_rows.h"
#include "server/storage/people/school_list.h"
#include "server/storage/people/session_rows.h"
#include "server/storage/people/setting_rows.h"
#include "server/storage/people/sign_in_rows.h"
#include "server/storage/people/station_rows.h"
#include "server/storage/recordings/ingest_rows.h"
#include "server/storage/recordings/recording_rows.h"
#include "server/storage/recordings/seal_rows.h"
#include "server/storage/recordings/sign_off_rows.h"
#include "server/storage/recordings/stored_blobs.h"
#include "server/storage/recordings/ticket_rows.h"
#include "server/storage/teaching/assignment_rows.h"
#include "server/storage/teaching/exercise_rows.h"
#include "server/storage/teaching/profile_rows.h"
#include "server/storage/teaching/rubric_rows.h"
#include "server/storage/teaching/scene_rows.h"
#include "server/storage/upkeep/erasures.h"
#include "server/storage/upkeep/retention_rows.h"
#include "server/storage/upkeep/store_health.h"

// Everything durable of a school, by subject: rows in SQLite or PostgreSQL, blobs and keys in a
// folder or in S3 stores (open_store.h). Both engines pass the same suite
// (tests/server/storage/backends.h). Every change is one transaction and leaves an audit row in the
// same transaction.
//
// Code that needs one or two subjects takes references to those; code that needs more takes the
// Store.
//
// Thread safety: any thread; calls block (one connection writes, with group commit, and a pool of
// them reads). Coroutines call it through StorePool (store_pool.h), never directly. Errors:
// kNotFound, kConflict, kStorage with what to do.
namespace enamel::server {

struct StoreEngine;  // store_engine.h

struct Store {
  explicit Store(std::unique_ptr<StoreEngine> on);
  ~Store();

  // Everything that the rows below use, also for code that copies or moves a whole school.
  const std::unique_ptr<StoreEngine> engine;
  // Other servers may have their rows in the same database.
  const bool shared;

  PeopleRows people;
  RosterRows roster;
  SessionRows sessions;
  SignInRows sign_ins;
  CohortRows cohorts;
  StationRows stations;
  DeviceRows devices;
  SettingRows settings;
  SavedTextRows saved_texts;
  SchoolRows schools;

  ProfileRows profiles;
  SceneRows scenes;
  ExerciseRows exercises;
  RubricRows rubrics;
  AssignmentRows assignments;

  StoredBlobs blobs;
  AttemptRows attempts;
  RecordingRows recordings;
  TicketRows tickets;
  SignOffRows sign_offs;
  IngestRows ingest;
  SealRows seals;
  MotionRows motions;
  ResultRows results;
  JudgingRows judging;
  RemarkRows remarks;
  AppealRows appeals;
  ReferenceRows references;
  JobRows jobs;
  BatchRows batches;
  TimelineRows timelines;
  LiveRows live;

  AuditRows audit;
  Erasures erasures;
  RetentionRows retention;
  StoreHealthCheck health;
  DatabaseLook& look;
  ServerIdentityRows identity;
  MarkingRows markings;

  // The program is about to end: no longer waits for other processes. FinishErasures, also at the
  // end of ErasePerson, leaves the rest to the next start. Any thread.
  void StopWaiting();
};

}  // namespace enamel::server
