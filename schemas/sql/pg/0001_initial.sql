-- Schema 1 of the server's store, in PostgreSQL 15: the tables, columns, keys, checks and indexes of
-- schemas/sql/0001_initial.sql, which says what they mean. A test compares the two files. SQLite's INTEGER is BIGINT
-- here, REAL is DOUBLE PRECISION, BLOB is BYTEA. Text is compared byte by byte ("C"), as SQLite does, whatever the
-- database's language is.

CREATE TABLE tenants (
  tenant BIGINT NOT NULL PRIMARY KEY,
  name   TEXT COLLATE "C" NOT NULL
);
INSERT INTO tenants (tenant, name) VALUES (1, 'default');

CREATE TABLE people (
  tenant               BIGINT NOT NULL REFERENCES tenants (tenant),
  id                   BYTEA NOT NULL CHECK (length(id) = 16),
  login                TEXT COLLATE "C" NOT NULL,
  display_name         TEXT COLLATE "C" NOT NULL,
  search_name          TEXT COLLATE "C" NOT NULL,
  role                 BIGINT NOT NULL CHECK (role BETWEEN 1 AND 3),
  disabled             BIGINT NOT NULL DEFAULT 0 CHECK (disabled IN (0, 1)),
  created_ms           BIGINT NOT NULL,
  verifier             TEXT COLLATE "C" NOT NULL,
  revision             BIGINT NOT NULL DEFAULT 1,
  must_change_password BIGINT NOT NULL DEFAULT 0 CHECK (must_change_password IN (0, 1)),
  password_ms          BIGINT NOT NULL DEFAULT 0,
  language             TEXT COLLATE "C" NOT NULL DEFAULT '' CHECK (language IN ('', 'en', 'de', 'zh')),
  pin                  TEXT COLLATE "C" NOT NULL DEFAULT '',
  wrong_pins           BIGINT NOT NULL DEFAULT 0 CHECK (wrong_pins BETWEEN 0 AND 10),
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, login)
);
CREATE INDEX people_by_role ON people (tenant, role, login);
CREATE UNIQUE INDEX people_by_name ON people (tenant, search_name, id);

CREATE TABLE cohorts (
  tenant      BIGINT NOT NULL REFERENCES tenants (tenant),
  id          BYTEA NOT NULL CHECK (length(id) = 16),
  name        TEXT COLLATE "C" NOT NULL,
  revision    BIGINT NOT NULL DEFAULT 1,
  archived_ms BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name)
);

CREATE TABLE cohort_members (
  tenant BIGINT NOT NULL,
  cohort BYTEA NOT NULL,
  person BYTEA NOT NULL,
  PRIMARY KEY (tenant, cohort, person),
  FOREIGN KEY (tenant, cohort) REFERENCES cohorts (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id)
);
CREATE INDEX cohort_members_by_person ON cohort_members (tenant, person);

CREATE TABLE stations (
  tenant          BIGINT NOT NULL REFERENCES tenants (tenant),
  id              BYTEA NOT NULL CHECK (length(id) = 16),
  name            TEXT COLLATE "C" NOT NULL,
  public_key      BYTEA NOT NULL CHECK (length(public_key) = 32),
  credential_hash BYTEA NOT NULL CHECK (length(credential_hash) = 32),
  revoked         BIGINT NOT NULL DEFAULT 0 CHECK (revoked IN (0, 1)),
  enrolled_ms     BIGINT NOT NULL,
  last_seen_ms    BIGINT NOT NULL,
  revision        BIGINT NOT NULL DEFAULT 1,
  revoked_ms      BIGINT NOT NULL DEFAULT 0,
  software        TEXT COLLATE "C" NOT NULL DEFAULT '',
  core_version    BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id)
);

CREATE TABLE profiles (
  tenant  BIGINT NOT NULL REFERENCES tenants (tenant),
  name    TEXT COLLATE "C" NOT NULL,
  title   TEXT COLLATE "C" NOT NULL,
  content BYTEA NOT NULL CHECK (length(content) = 32),
  PRIMARY KEY (tenant, name)
);

CREATE TABLE scenes (
  tenant  BIGINT NOT NULL REFERENCES tenants (tenant),
  name    TEXT COLLATE "C" NOT NULL,
  title   TEXT COLLATE "C" NOT NULL,
  content BYTEA NOT NULL CHECK (length(content) = 32),
  volume  BYTEA NOT NULL CHECK (length(volume) = 32),
  surface BYTEA CHECK (length(surface) = 32),
  PRIMARY KEY (tenant, content)
);

CREATE TABLE exercises (
  tenant       BIGINT NOT NULL REFERENCES tenants (tenant),
  id           BYTEA NOT NULL CHECK (length(id) = 16),
  name         TEXT COLLATE "C" NOT NULL,
  version      BIGINT NOT NULL,
  title        TEXT COLLATE "C" NOT NULL,
  content      BYTEA NOT NULL CHECK (length(content) = 32),
  scene        BYTEA NOT NULL,
  graded       BIGINT NOT NULL CHECK (graded IN (0, 1)),
  published_ms BIGINT NOT NULL,
  state        BIGINT NOT NULL DEFAULT 2 CHECK (state BETWEEN 1 AND 3),
  revision     BIGINT NOT NULL DEFAULT 1,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name, version),
  FOREIGN KEY (tenant, scene) REFERENCES scenes (tenant, content)
);
CREATE INDEX exercises_by_content ON exercises (tenant, content);

-- Each chunk updates its attempt's row. Half of each page stays free for the next version of a row, and a ticket and a
-- header are stored apart from 128 bytes on. So the next version fits beside the last and no index is touched (a
-- heap-only update).
CREATE TABLE attempts (
  tenant          BIGINT NOT NULL REFERENCES tenants (tenant),
  id              BYTEA NOT NULL CHECK (length(id) = 16),
  person          BYTEA NOT NULL,
  station         BYTEA NOT NULL,
  exercise        BYTEA NOT NULL,
  profile_content BYTEA NOT NULL CHECK (length(profile_content) = 32),
  state           BIGINT NOT NULL CHECK (state BETWEEN 1 AND 7),
  as_reference    BIGINT NOT NULL DEFAULT 0 CHECK (as_reference IN (0, 1)),
  released        BIGINT NOT NULL DEFAULT 0 CHECK (released IN (0, 1)),
  ticketed_ms     BIGINT NOT NULL,
  sealed_ms       BIGINT NOT NULL DEFAULT 0,
  ticket          BYTEA NOT NULL,
  header          BYTEA,
  head_hash       BYTEA CHECK (length(head_hash) = 32),
  head_state_hash BIGINT NOT NULL DEFAULT 0,
  chunks          BIGINT NOT NULL DEFAULT 0,
  ticks           BIGINT NOT NULL DEFAULT 0,
  gap_ticks       BIGINT NOT NULL DEFAULT 0,
  trace_bytes     BIGINT NOT NULL DEFAULT 0,
  trace_blob      BYTEA CHECK (length(trace_blob) = 32),
  progress        DOUBLE PRECISION NOT NULL DEFAULT 0,
  problem         TEXT COLLATE "C" NOT NULL DEFAULT '',
  problem_field   TEXT COLLATE "C" NOT NULL DEFAULT '',
  score           DOUBLE PRECISION,
  critical_fail   BIGINT NOT NULL DEFAULT 0 CHECK (critical_fail IN (0, 1)),
  score_json      BYTEA,
  final_volume    BYTEA,
  deviation       BYTEA,
  series          BYTEA,
  reference       BYTEA,
  expired_ms      BIGINT NOT NULL DEFAULT 0,
  assignment      BYTEA CHECK (length(assignment) = 16),
  exam            BIGINT NOT NULL DEFAULT 0 CHECK (exam IN (0, 1)),
  due_ms          BIGINT NOT NULL DEFAULT 0,
  rate_hz         BIGINT NOT NULL DEFAULT 0,
  limit_ticks     BIGINT NOT NULL DEFAULT 0,
  last_chunk_ms   BIGINT NOT NULL DEFAULT 0,
  flags           BIGINT NOT NULL DEFAULT 0,
  override_score  DOUBLE PRECISION,
  override_reason TEXT COLLATE "C" NOT NULL DEFAULT '',
  override_by     BYTEA CHECK (length(override_by) = 16),
  override_ms     BIGINT NOT NULL DEFAULT 0,
  revision        BIGINT NOT NULL DEFAULT 1,
  facts           TEXT COLLATE "C" NOT NULL DEFAULT '{}',
  hands           BIGINT NOT NULL DEFAULT 4,
  sign_off        BIGINT NOT NULL DEFAULT 0 CHECK (sign_off IN (0, 1)),
  hand_kind       BIGINT NOT NULL DEFAULT 0,
  hand_device     TEXT COLLATE "C" NOT NULL DEFAULT '',
  hand_driver     TEXT COLLATE "C" NOT NULL DEFAULT '',
  hand_unit       TEXT COLLATE "C" NOT NULL DEFAULT '',
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id),
  FOREIGN KEY (tenant, station) REFERENCES stations (tenant, id),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id)
) WITH (fillfactor = 50, toast_tuple_target = 128);
CREATE INDEX attempts_by_person ON attempts (tenant, person, id);
CREATE INDEX attempts_by_exercise ON attempts (tenant, exercise, id);
CREATE INDEX attempts_by_reference ON attempts (tenant, reference) WHERE reference IS NOT NULL;
CREATE INDEX attempts_by_assignment ON attempts (tenant, assignment, id) WHERE assignment IS NOT NULL;
CREATE INDEX attempts_by_score ON attempts (tenant, coalesce(override_score, score, 1000.0), id DESC);

CREATE TABLE sign_offs (
  tenant    BIGINT NOT NULL,
  attempt   BYTEA NOT NULL,
  stage     TEXT COLLATE "C" NOT NULL CHECK (stage IN ('end', 'start')),
  signer    BYTEA NOT NULL CHECK (length(signer) = 16),
  signed_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, attempt, stage),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);

CREATE TABLE trace_chunks (
  tenant      BIGINT NOT NULL,
  attempt     BYTEA NOT NULL,
  seq         BIGINT NOT NULL,
  hash        BYTEA NOT NULL CHECK (length(hash) = 32),
  bytes       BYTEA NOT NULL,
  received_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, attempt, seq),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);

CREATE TABLE trace_parts (
  tenant     BIGINT NOT NULL,
  attempt    BYTEA NOT NULL,
  next_chunk BIGINT NOT NULL,
  content    BYTEA NOT NULL CHECK (length(content) = 32),
  PRIMARY KEY (tenant, attempt, next_chunk),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);

CREATE TABLE contradicting_chunks (
  tenant      BIGINT NOT NULL,
  attempt     BYTEA NOT NULL,
  seq         BIGINT NOT NULL,
  hash        BYTEA NOT NULL CHECK (length(hash) = 32),
  bytes       BYTEA NOT NULL,
  received_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, attempt, seq, hash),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);

CREATE TABLE reference_cuts (
  tenant       BIGINT NOT NULL,
  id           BYTEA NOT NULL CHECK (length(id) = 16),
  exercise     BYTEA NOT NULL,
  attempt      BYTEA NOT NULL,
  dentist      TEXT COLLATE "C" NOT NULL,
  version      BIGINT NOT NULL,
  created_ms   BIGINT NOT NULL,
  consent      BIGINT NOT NULL DEFAULT 1 CHECK (consent IN (0, 1)),
  withdrawn_ms BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, exercise, version),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);

CREATE TABLE audit (
  tenant       BIGINT NOT NULL REFERENCES tenants (tenant),
  id           BYTEA NOT NULL CHECK (length(id) = 16),
  at_ms        BIGINT NOT NULL,
  actor        BYTEA NOT NULL CHECK (length(actor) = 16),
  via          TEXT COLLATE "C" NOT NULL,
  action       TEXT COLLATE "C" NOT NULL,
  object       TEXT COLLATE "C" NOT NULL,
  before_json  TEXT COLLATE "C" NOT NULL,
  after_json   TEXT COLLATE "C" NOT NULL,
  subject      TEXT COLLATE "C" NOT NULL,
  state        TEXT COLLATE "C" NOT NULL,
  salt         BYTEA CHECK (length(salt) = 32),
  content_hash BYTEA NOT NULL CHECK (length(content_hash) = 32),
  signature    BYTEA NOT NULL CHECK (length(signature) = 64),
  chain        BYTEA NOT NULL CHECK (length(chain) = 16),
  number       BIGINT NOT NULL CHECK (number > 0),
  previous     BYTEA NOT NULL CHECK (length(previous) = 32),
  PRIMARY KEY (tenant, id)
);
CREATE INDEX audit_by_object ON audit (tenant, object, id);
CREATE INDEX audit_by_actor ON audit (tenant, actor, id);
CREATE INDEX audit_by_subject ON audit (tenant, subject, id) WHERE subject <> '';
CREATE UNIQUE INDEX audit_by_number ON audit (tenant, chain, number);

CREATE TABLE erasures (
  tenant      BIGINT NOT NULL REFERENCES tenants (tenant),
  person_hash BYTEA NOT NULL CHECK (length(person_hash) = 32),
  erased_ms   BIGINT NOT NULL,
  PRIMARY KEY (tenant, person_hash)
);

CREATE TABLE retention_rules (
  tenant BIGINT NOT NULL REFERENCES tenants (tenant),
  what   TEXT COLLATE "C" NOT NULL CHECK (what IN ('unfinished', 'recordings', 'attempts')),
  days   BIGINT NOT NULL CHECK (days BETWEEN 1 AND 36500),
  PRIMARY KEY (tenant, what)
);

CREATE TABLE assignments (
  tenant        BIGINT NOT NULL REFERENCES tenants (tenant),
  id            BYTEA NOT NULL CHECK (length(id) = 16),
  exercise_name TEXT COLLATE "C" NOT NULL,
  cohort        BYTEA NOT NULL CHECK (length(cohort) = 16),
  opens_ms      BIGINT NOT NULL DEFAULT 0 CHECK (opens_ms >= 0),
  due_ms        BIGINT NOT NULL DEFAULT 0 CHECK (due_ms >= 0),
  attempt_limit BIGINT NOT NULL DEFAULT 0 CHECK (attempt_limit >= 0),
  exam          BIGINT NOT NULL DEFAULT 0 CHECK (exam IN (0, 1)),
  late_allowed  BIGINT NOT NULL DEFAULT 0 CHECK (late_allowed IN (0, 1)),
  revision      BIGINT NOT NULL DEFAULT 1,
  created_ms    BIGINT NOT NULL DEFAULT 0,
  hands         BIGINT NOT NULL DEFAULT 4,
  exercise      BYTEA NOT NULL CHECK (length(exercise) = 16),
  counting      TEXT COLLATE "C" NOT NULL DEFAULT 'best' CHECK (counting IN ('best', 'last', 'mean', 'median')),
  sign_off      BIGINT NOT NULL DEFAULT 0 CHECK (sign_off IN (0, 1)),
  PRIMARY KEY (tenant, id)
);
CREATE INDEX assignments_by_exercise ON assignments (tenant, exercise_name, cohort);
CREATE INDEX assignments_by_cohort ON assignments (tenant, cohort);

CREATE TABLE assignment_stations (
  tenant     BIGINT NOT NULL,
  assignment BYTEA NOT NULL,
  station    BYTEA NOT NULL,
  PRIMARY KEY (tenant, assignment, station),
  FOREIGN KEY (tenant, assignment) REFERENCES assignments (tenant, id) ON DELETE CASCADE,
  FOREIGN KEY (tenant, station) REFERENCES stations (tenant, id)
);

CREATE TABLE attempt_results (
  tenant                 BIGINT NOT NULL,
  attempt                BYTEA NOT NULL,
  run                    BIGINT NOT NULL,
  scored_ms              BIGINT NOT NULL,
  cause                  TEXT COLLATE "C" NOT NULL,
  score                  DOUBLE PRECISION NOT NULL,
  critical_fail          BIGINT NOT NULL CHECK (critical_fail IN (0, 1)),
  score_json             BYTEA NOT NULL,
  reference              BYTEA,
  replay_realtime_factor DOUBLE PRECISION NOT NULL DEFAULT 0,
  document               BYTEA NOT NULL,
  final_volume           BYTEA CHECK (length(final_volume) = 32),
  deviation              BYTEA CHECK (length(deviation) = 32),
  series                 BYTEA CHECK (length(series) = 32),
  PRIMARY KEY (tenant, attempt, run),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);
CREATE INDEX attempt_results_by_reference ON attempt_results (tenant, reference) WHERE reference IS NOT NULL;

CREATE TABLE annotations (
  tenant       BIGINT NOT NULL,
  id           BYTEA NOT NULL CHECK (length(id) = 16),
  attempt      BYTEA NOT NULL,
  author       BYTEA NOT NULL CHECK (length(author) = 16),
  tick         BIGINT NOT NULL CHECK (tick >= 0),
  x_um         BIGINT,
  y_um         BIGINT,
  z_um         BIGINT,
  text         TEXT COLLATE "C" NOT NULL,
  created_ms   BIGINT NOT NULL,
  edited_ms    BIGINT NOT NULL DEFAULT 0,
  revision     BIGINT NOT NULL DEFAULT 1,
  to_chair     BIGINT NOT NULL DEFAULT 0 CHECK (to_chair IN (0, 1)),
  remark_id    BIGINT CHECK (remark_id > 0),
  remark_state TEXT COLLATE "C" CHECK (remark_state IN ('waiting', 'sent', 'shown')),
  shown_ms     BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);
CREATE INDEX annotations_by_attempt ON annotations (tenant, attempt, tick, id);
CREATE INDEX annotations_to_chairs ON annotations (tenant, created_ms) WHERE remark_id IS NOT NULL;

CREATE TABLE appeals (
  tenant      BIGINT NOT NULL,
  attempt     BYTEA NOT NULL,
  filed_ms    BIGINT NOT NULL,
  text        TEXT COLLATE "C" NOT NULL,
  state       TEXT COLLATE "C" NOT NULL CHECK (state IN ('open', 'regraded', 'rejected')),
  answer      TEXT COLLATE "C" NOT NULL DEFAULT '',
  answered_by BYTEA CHECK (length(answered_by) = 16),
  answered_ms BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);
CREATE INDEX appeals_open ON appeals (tenant, filed_ms) WHERE state = 'open';

CREATE TABLE markings (
  tenant     BIGINT NOT NULL,
  id         BYTEA NOT NULL CHECK (length(id) = 16),
  assignment BYTEA NOT NULL,
  created_ms BIGINT NOT NULL,
  ended_ms   BIGINT NOT NULL DEFAULT 0 CHECK (ended_ms >= 0),
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, assignment) REFERENCES assignments (tenant, id) ON DELETE CASCADE
);
CREATE INDEX markings_by_assignment ON markings (tenant, assignment);

CREATE TABLE marking_people (
  tenant  BIGINT NOT NULL,
  marking BYTEA NOT NULL,
  person  BYTEA NOT NULL CHECK (length(person) = 16),
  removed_ms BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, marking, person),
  FOREIGN KEY (tenant, marking) REFERENCES markings (tenant, id) ON DELETE CASCADE
);
CREATE INDEX marking_people_by_person ON marking_people (tenant, person);

CREATE TABLE marking_works (
  tenant  BIGINT NOT NULL,
  id      BYTEA NOT NULL CHECK (length(id) = 16),
  marking BYTEA NOT NULL,
  attempt BYTEA NOT NULL,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, marking, attempt),
  FOREIGN KEY (tenant, marking) REFERENCES markings (tenant, id) ON DELETE CASCADE,
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);
CREATE INDEX marking_works_by_attempt ON marking_works (tenant, attempt);

CREATE TABLE marks (
  tenant   BIGINT NOT NULL,
  work     BYTEA NOT NULL,
  marker   BYTEA NOT NULL CHECK (length(marker) = 16),
  rating   BIGINT NOT NULL CHECK (rating BETWEEN 1 AND 5),
  criteria TEXT COLLATE "C" NOT NULL,
  made_ms  BIGINT NOT NULL,
  PRIMARY KEY (tenant, work, marker),
  FOREIGN KEY (tenant, work) REFERENCES marking_works (tenant, id) ON DELETE CASCADE
);
CREATE INDEX marks_by_marker ON marks (tenant, marker, made_ms);

CREATE TABLE jobs (
  tenant         BIGINT NOT NULL,
  id             BYTEA NOT NULL CHECK (length(id) = 16),
  kind           TEXT COLLATE "C" NOT NULL,
  attempt        BYTEA NOT NULL,
  cause          TEXT COLLATE "C" NOT NULL DEFAULT 'seal',
  state          TEXT COLLATE "C" NOT NULL CHECK (state IN ('queued', 'running', 'done', 'failed', 'cancelled')),
  tries          BIGINT NOT NULL DEFAULT 0,
  lease_until_ms BIGINT NOT NULL DEFAULT 0,
  error          TEXT COLLATE "C" NOT NULL DEFAULT '',
  batch          BYTEA,
  lease          BYTEA CHECK (length(lease) = 16),
  owner          BYTEA CHECK (length(owner) = 16),
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);
CREATE INDEX jobs_open ON jobs (tenant, id) WHERE state IN ('queued', 'running');
CREATE INDEX jobs_by_attempt ON jobs (tenant, attempt, id);
CREATE INDEX jobs_by_batch ON jobs (tenant, batch) WHERE batch IS NOT NULL;
CREATE UNIQUE INDEX jobs_by_lease ON jobs (tenant, lease) WHERE lease IS NOT NULL;
CREATE UNIQUE INDEX jobs_running ON jobs (tenant, attempt) WHERE state = 'running';

CREATE TABLE sessions (
  tenant       BIGINT NOT NULL,
  token_hash   BYTEA NOT NULL CHECK (length(token_hash) = 32),
  id           BYTEA NOT NULL CHECK (length(id) = 16),
  person       BYTEA NOT NULL,
  created_ms   BIGINT NOT NULL,
  last_used_ms BIGINT NOT NULL,
  expires_ms   BIGINT NOT NULL,
  confirmed_ms BIGINT NOT NULL,
  via          TEXT COLLATE "C" NOT NULL,
  address      TEXT COLLATE "C" NOT NULL DEFAULT '',
  device       TEXT COLLATE "C" NOT NULL DEFAULT '',
  PRIMARY KEY (tenant, token_hash),
  UNIQUE (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id) ON DELETE CASCADE
);
CREATE INDEX sessions_by_end ON sessions (tenant, expires_ms);
CREATE INDEX sessions_by_person ON sessions (tenant, person);

CREATE TABLE enrol_codes (
  tenant       BIGINT NOT NULL REFERENCES tenants (tenant),
  code_hash    BYTEA NOT NULL CHECK (length(code_hash) = 32),
  id           BYTEA NOT NULL CHECK (length(id) = 16),
  created_ms   BIGINT NOT NULL,
  expires_ms   BIGINT NOT NULL,
  used_ms      BIGINT,
  withdrawn_ms BIGINT,
  PRIMARY KEY (tenant, code_hash),
  UNIQUE (tenant, id)
);

CREATE TABLE profile_versions (
  tenant     BIGINT NOT NULL REFERENCES tenants (tenant),
  name       TEXT COLLATE "C" NOT NULL,
  version    BIGINT NOT NULL CHECK (version >= 1),
  title      TEXT COLLATE "C" NOT NULL,
  content    BYTEA NOT NULL CHECK (length(content) = 32),
  created_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, name, version)
);

CREATE TABLE profile_reports (
  tenant     BIGINT NOT NULL,
  id         BYTEA NOT NULL CHECK (length(id) = 16),
  name       TEXT COLLATE "C" NOT NULL,
  version    BIGINT NOT NULL,
  media_type TEXT COLLATE "C" NOT NULL CHECK (media_type IN ('application/json', 'text/html')),
  content    BYTEA NOT NULL CHECK (length(content) = 32),
  bytes      BIGINT NOT NULL,
  created_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name, version, content),
  FOREIGN KEY (tenant, name, version) REFERENCES profile_versions (tenant, name, version)
);

CREATE TABLE calibrations (
  tenant      BIGINT NOT NULL,
  id          BYTEA NOT NULL CHECK (length(id) = 16),
  profile     TEXT COLLATE "C" NOT NULL,
  device      TEXT COLLATE "C" NOT NULL,
  measured_ms BIGINT NOT NULL,
  added_ms    BIGINT NOT NULL,
  document    TEXT COLLATE "C" NOT NULL,
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, profile) REFERENCES profiles (tenant, name)
);
-- An index entry is too small for a document, so this one has its hash. Nobody gains from two documents with one MD5.
CREATE UNIQUE INDEX calibrations_once ON calibrations (tenant, profile, md5(document));
CREATE INDEX calibrations_by_profile ON calibrations (tenant, profile, measured_ms);

CREATE TABLE write_probe (
  tenant   BIGINT NOT NULL,
  server   BYTEA NOT NULL CHECK (length(server) = 16),
  at_ms    BIGINT NOT NULL,  -- the database's clock
  ahead_ms BIGINT NOT NULL,  -- how far the server's own clock is ahead of it
  beats    BIGINT NOT NULL,  -- one more with each writing
  host     TEXT COLLATE "C" NOT NULL,  -- where its station link listens, numeric; empty: not known
  port     BIGINT NOT NULL,
  PRIMARY KEY (tenant, server)
);

CREATE TABLE rubrics (
  tenant       BIGINT NOT NULL,
  exercise     BYTEA NOT NULL,
  version      BIGINT NOT NULL CHECK (version > 1),
  content      BYTEA NOT NULL CHECK (length(content) = 32),
  reason       TEXT COLLATE "C" NOT NULL,
  published_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, exercise, version),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id)
);

CREATE TABLE job_batches (
  tenant    BIGINT NOT NULL REFERENCES tenants (tenant),
  id        BYTEA NOT NULL CHECK (length(id) = 16),
  title     TEXT COLLATE "C" NOT NULL,
  cohort    BYTEA,
  cause     TEXT COLLATE "C" NOT NULL,
  queued_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, id)
);

CREATE TABLE listed_devices (
  tenant   BIGINT NOT NULL REFERENCES tenants (tenant),
  name     TEXT COLLATE "C" NOT NULL,
  title    TEXT COLLATE "C" NOT NULL,
  added_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, name)
);

CREATE TABLE station_settings (
  tenant     BIGINT NOT NULL REFERENCES tenants (tenant),
  name       TEXT COLLATE "C" NOT NULL,
  scope      TEXT COLLATE "C" NOT NULL,
  value      TEXT COLLATE "C" NOT NULL,
  fixed      BIGINT NOT NULL CHECK (fixed IN (0, 1)),
  changed_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, name, scope)
);

CREATE TABLE saved_texts (
  tenant   BIGINT NOT NULL,
  id       BYTEA NOT NULL CHECK (length(id) = 16),
  owner    BYTEA NOT NULL,
  text     TEXT COLLATE "C" NOT NULL,
  shared   BIGINT NOT NULL CHECK (shared IN (0, 1)),
  saved_ms BIGINT NOT NULL,
  revision BIGINT NOT NULL DEFAULT 1,
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, owner) REFERENCES people (tenant, id)
);
CREATE INDEX saved_texts_by_owner ON saved_texts (tenant, owner);
CREATE INDEX saved_texts_shared ON saved_texts (tenant) WHERE shared = 1;

CREATE TABLE exercise_owners (
  tenant BIGINT NOT NULL REFERENCES tenants (tenant),
  name   TEXT COLLATE "C" NOT NULL,
  owner  BYTEA,
  shared BIGINT NOT NULL CHECK (shared IN (0, 1)),
  PRIMARY KEY (tenant, name),
  FOREIGN KEY (tenant, owner) REFERENCES people (tenant, id)
);

CREATE TABLE timelines (
  tenant         BIGINT NOT NULL,
  attempt        BYTEA NOT NULL,
  content        BYTEA CHECK (length(content) = 32),
  tries          BIGINT NOT NULL DEFAULT 0,
  problem        TEXT COLLATE "C" NOT NULL DEFAULT '',
  owner          BYTEA CHECK (length(owner) = 16),
  lease_until_ms BIGINT NOT NULL DEFAULT 0,
  asked_ms       BIGINT NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);
CREATE INDEX timelines_to_make ON timelines (tenant, attempt) WHERE content IS NULL;

CREATE TABLE start_teeth (
  tenant  BIGINT NOT NULL REFERENCES tenants (tenant),
  volume  BYTEA NOT NULL CHECK (length(volume) = 32),
  content BYTEA NOT NULL CHECK (length(content) = 32),
  PRIMARY KEY (tenant, volume)
);
CREATE INDEX start_teeth_by_content ON start_teeth (tenant, content);

CREATE TABLE motions (
  tenant     BIGINT NOT NULL,
  attempt    BYTEA NOT NULL,
  content    BYTEA NOT NULL CHECK (length(content) = 32),
  nearest    BYTEA CHECK (length(nearest) = 16),
  others     BIGINT NOT NULL,
  nearest_um BIGINT NOT NULL,
  median_um  BIGINT NOT NULL,
  size_um    BIGINT NOT NULL,
  preset     BYTEA CHECK (length(preset) = 16),
  presets    BIGINT NOT NULL,
  preset_um  BIGINT NOT NULL,
  tremor_nm  BIGINT NOT NULL,
  still_ppm  BIGINT NOT NULL,
  late_ppm   BIGINT NOT NULL,
  gap_ppm    BIGINT NOT NULL,
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
);
CREATE INDEX motions_by_nearest ON motions (tenant, nearest) WHERE nearest IS NOT NULL;
CREATE INDEX motions_by_preset ON motions (tenant, preset) WHERE preset IS NOT NULL;

CREATE TABLE audit_heads (
  tenant    BIGINT NOT NULL,
  chain     BYTEA NOT NULL CHECK (length(chain) = 16),
  number    BIGINT NOT NULL CHECK (number > 0),
  last_id   BYTEA NOT NULL CHECK (length(last_id) = 16),
  hash      BYTEA NOT NULL CHECK (length(hash) = 32),
  signature BYTEA NOT NULL CHECK (length(signature) = 64),
  PRIMARY KEY (tenant, chain)
);

CREATE TABLE blobs (
  tenant     BIGINT NOT NULL REFERENCES tenants (tenant),
  hash       BYTEA NOT NULL CHECK (length(hash) = 32),
  bytes      BIGINT NOT NULL CHECK (bytes >= 0),
  generation BIGINT NOT NULL CHECK (generation > 0),
  put_ms     BIGINT NOT NULL,
  PRIMARY KEY (tenant, hash)
);

CREATE TABLE person_keys (
  tenant     BIGINT NOT NULL REFERENCES tenants (tenant),
  person     BYTEA NOT NULL CHECK (length(person) = 16),
  generation BIGINT NOT NULL CHECK (generation > 0),
  hash       BYTEA NOT NULL CHECK (length(hash) = 32),
  made_ms    BIGINT NOT NULL,
  PRIMARY KEY (tenant, person)
);

CREATE TABLE server_identity (
  tenant      BIGINT NOT NULL REFERENCES tenants (tenant),
  name        TEXT COLLATE "C" NOT NULL CHECK (name IN ('station_certificate', 'ticket_key', 'key_ring')),
  fingerprint BYTEA NOT NULL CHECK (length(fingerprint) = 32),
  PRIMARY KEY (tenant, name)
);

CREATE UNLOGGED TABLE sign_in_counters (
  tenant      BIGINT NOT NULL REFERENCES tenants (tenant),
  key         BYTEA NOT NULL CHECK (length(key) = 32),
  failures    BIGINT NOT NULL CHECK (failures >= 0),
  first_tries BIGINT NOT NULL CHECK (first_tries >= 0),
  last_ms     BIGINT NOT NULL,
  next_try_ms BIGINT NOT NULL,
  until_ms    BIGINT NOT NULL,
  PRIMARY KEY (tenant, key)
);
CREATE INDEX sign_in_counters_by_end ON sign_in_counters (tenant, until_ms);

CREATE TABLE leases (
  tenant   BIGINT NOT NULL REFERENCES tenants (tenant),
  name     TEXT COLLATE "C" NOT NULL CHECK (name IN ('upkeep')),
  lease    BYTEA NOT NULL CHECK (length(lease) = 16),
  until_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, name)
);

CREATE TABLE rewrite_due (
  tenant   BIGINT NOT NULL PRIMARY KEY REFERENCES tenants (tenant),
  since_ms BIGINT NOT NULL,
  mark     BYTEA NOT NULL CHECK (length(mark) = 16)
);

CREATE UNLOGGED TABLE running_servers (
  tenant   BIGINT NOT NULL REFERENCES tenants (tenant),
  server   BYTEA NOT NULL CHECK (length(server) = 16),
  heard_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, server)
);
CREATE UNLOGGED TABLE station_links (
  tenant        BIGINT NOT NULL REFERENCES tenants (tenant),
  server        BYTEA NOT NULL CHECK (length(server) = 16),
  station       BYTEA NOT NULL CHECK (length(station) = 16),
  shows_remarks BIGINT NOT NULL CHECK (shows_remarks IN (0, 1)),
  PRIMARY KEY (tenant, server, station)
);

CREATE TABLE schools (
  tenant     BIGINT NOT NULL REFERENCES tenants (tenant),
  name       TEXT COLLATE "C" NOT NULL,
  id         BYTEA NOT NULL CHECK (length(id) = 16),
  hosts      TEXT COLLATE "C" NOT NULL,
  state      TEXT COLLATE "C" NOT NULL CHECK (state IN ('being_made', 'served', 'suspended', 'being_deleted')),
  created_ms BIGINT NOT NULL,
  PRIMARY KEY (tenant, name)
);

CREATE TABLE move_marks (
  tenant BIGINT NOT NULL REFERENCES tenants (tenant),
  mark   TEXT COLLATE "C" NOT NULL CHECK (mark IN ('moved', 'moving')),
  PRIMARY KEY (tenant, mark)
);

-- What SQLite's RAISE(ABORT, ...) does.
CREATE FUNCTION enamel_refuse() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  RAISE EXCEPTION '%', TG_ARGV[0];
END $$;

CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
  FOR EACH ROW EXECUTE FUNCTION enamel_refuse('audit rows are never deleted');

CREATE FUNCTION enamel_audit_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NOT (
    NEW.tenant = OLD.tenant AND NEW.id = OLD.id AND NEW.at_ms = OLD.at_ms AND NEW.actor = OLD.actor AND
    NEW.via = OLD.via AND NEW.action = OLD.action AND NEW.object = OLD.object AND NEW.subject = OLD.subject AND
    NEW.content_hash = OLD.content_hash AND NEW.signature = OLD.signature AND NEW.chain = OLD.chain AND
    NEW.number = OLD.number AND NEW.previous = OLD.previous AND NEW.salt IS NULL AND
    NEW.state = CASE OLD.state WHEN '' THEN '' ELSE '{"erased":true}' END AND
    NEW.before_json = '{"erased":true}' AND NEW.after_json = '{"erased":true}' AND (
      ((OLD.action LIKE 'person.%' OR OLD.action LIKE 'session.%' OR OLD.action = 'request.refused') AND
       NOT EXISTS (SELECT 1 FROM people p WHERE p.tenant = OLD.tenant AND
                   encode(p.id, 'hex') = replace(OLD.object, '-', ''))) OR
      (OLD.action <> 'attempt.ticket' AND
       EXISTS (SELECT 1 FROM audit t WHERE t.tenant = OLD.tenant AND t.object = OLD.object AND
               t.action = 'attempt.ticket' AND
               replace(t.after_json::json ->> 'person', '-', '') NOT IN
                 (SELECT encode(p.id, 'hex') FROM people p WHERE p.tenant = OLD.tenant)))))
  THEN
    RAISE EXCEPTION 'audit rows are never changed';
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
  FOR EACH ROW EXECUTE FUNCTION enamel_audit_change();

CREATE TRIGGER audit_heads_are_not_deleted BEFORE DELETE ON audit_heads
  FOR EACH ROW EXECUTE FUNCTION enamel_refuse('the audit trail only grows');
CREATE TRIGGER audit_heads_only_advance BEFORE UPDATE ON audit_heads
  FOR EACH ROW WHEN (NOT (NEW.tenant = OLD.tenant AND NEW.chain = OLD.chain AND NEW.number > OLD.number))
  EXECUTE FUNCTION enamel_refuse('the audit trail only grows');
