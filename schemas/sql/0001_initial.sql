-- Schema 1 of the server's store, in SQLite. The server makes its tables and indexes for PostgreSQL from it and adds
-- schemas/sql/pg/0001_initial.sql.
--
-- The tenant leads every key. Ids are UUIDv7 (16 bytes, sort by age), times are milliseconds since the Unix epoch,
-- hashes are SHA-256 (32 bytes). Large content is in blobs, which rows name by their hash. Migrations are numbered and
-- only go forward; those that are missing run in one transaction.

CREATE TABLE tenants (
  tenant INTEGER NOT NULL PRIMARY KEY,
  name   TEXT NOT NULL
) STRICT;
INSERT INTO tenants (tenant, name) VALUES (1, 'default');

CREATE TABLE people (
  tenant               INTEGER NOT NULL REFERENCES tenants (tenant),
  id                   BLOB NOT NULL CHECK (length(id) = 16),
  login                TEXT NOT NULL,
  display_name         TEXT NOT NULL,
  search_name          TEXT NOT NULL,  -- of the display name: without case and accents
  role                 INTEGER NOT NULL CHECK (role BETWEEN 1 AND 3),  -- 1 student, 2 instructor, 3 admin
  disabled             INTEGER NOT NULL DEFAULT 0 CHECK (disabled IN (0, 1)),
  created_ms           INTEGER NOT NULL,
  verifier             TEXT NOT NULL,  -- argon2id, libsodium's form
  revision             INTEGER NOT NULL DEFAULT 1,
  must_change_password INTEGER NOT NULL DEFAULT 0 CHECK (must_change_password IN (0, 1)),
  password_ms          INTEGER NOT NULL DEFAULT 0,
  -- A language of the page (schemas/words.md); empty: the browser's.
  language             TEXT NOT NULL DEFAULT '' CHECK (language IN ('', 'en', 'de', 'zh')),
  -- argon2id, as the verifier: signs exams at a chair; empty: none was chosen.
  pin                  TEXT NOT NULL DEFAULT '',
  -- Tries of the PIN since the last right one. At 10 it is locked.
  wrong_pins           INTEGER NOT NULL DEFAULT 0 CHECK (wrong_pins BETWEEN 0 AND 10),
  may_import_teeth     INTEGER NOT NULL DEFAULT 0 CHECK (may_import_teeth IN (0, 1)),  -- as an instructor
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, login)
) STRICT, WITHOUT ROWID;
CREATE INDEX people_by_role ON people (tenant, role, login);
CREATE UNIQUE INDEX people_by_name ON people (tenant, search_name, id);

CREATE TABLE cohorts (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  id          BLOB NOT NULL CHECK (length(id) = 16),
  name        TEXT NOT NULL,
  revision    INTEGER NOT NULL DEFAULT 1,
  archived_ms INTEGER NOT NULL DEFAULT 0,  -- 0: in use
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name)
) STRICT, WITHOUT ROWID;

CREATE TABLE cohort_members (
  tenant INTEGER NOT NULL,
  cohort BLOB NOT NULL,
  person BLOB NOT NULL,
  PRIMARY KEY (tenant, cohort, person),
  FOREIGN KEY (tenant, cohort) REFERENCES cohorts (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX cohort_members_by_person ON cohort_members (tenant, person);

CREATE TABLE stations (
  tenant          INTEGER NOT NULL REFERENCES tenants (tenant),
  id              BLOB NOT NULL CHECK (length(id) = 16),
  name            TEXT NOT NULL,
  public_key      BLOB NOT NULL CHECK (length(public_key) = 32),  -- Ed25519, checks chunks
  credential_hash BLOB NOT NULL CHECK (length(credential_hash) = 32),
  revoked         INTEGER NOT NULL DEFAULT 0 CHECK (revoked IN (0, 1)),
  enrolled_ms     INTEGER NOT NULL,
  last_seen_ms    INTEGER NOT NULL,
  revision        INTEGER NOT NULL DEFAULT 1,
  revoked_ms      INTEGER NOT NULL DEFAULT 0,
  software        TEXT NOT NULL DEFAULT '',
  core_version    INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;

CREATE TABLE profiles (
  tenant  INTEGER NOT NULL REFERENCES tenants (tenant),
  name    TEXT NOT NULL,
  title   TEXT NOT NULL,
  content BLOB NOT NULL CHECK (length(content) = 32),
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;

CREATE TABLE scenes (
  tenant  INTEGER NOT NULL REFERENCES tenants (tenant),
  name    TEXT NOT NULL,
  title   TEXT NOT NULL,
  content BLOB NOT NULL CHECK (length(content) = 32),
  volume  BLOB NOT NULL CHECK (length(volume) = 32),
  surface BLOB CHECK (length(surface) = 32),
  PRIMARY KEY (tenant, content)
) STRICT, WITHOUT ROWID;

CREATE TABLE exercises (
  tenant       INTEGER NOT NULL REFERENCES tenants (tenant),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  name         TEXT NOT NULL,
  version      INTEGER NOT NULL,
  title        TEXT NOT NULL,
  content      BLOB NOT NULL CHECK (length(content) = 32),
  scene        BLOB NOT NULL,
  graded       INTEGER NOT NULL CHECK (graded IN (0, 1)),
  published_ms INTEGER NOT NULL,
  state        INTEGER NOT NULL DEFAULT 2 CHECK (state BETWEEN 1 AND 3),
  revision     INTEGER NOT NULL DEFAULT 1,  -- counts the changes of a draft
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name, version),
  FOREIGN KEY (tenant, scene) REFERENCES scenes (tenant, content)
) STRICT, WITHOUT ROWID;
CREATE INDEX exercises_by_content ON exercises (tenant, content);

CREATE TABLE attempts (
  tenant          INTEGER NOT NULL REFERENCES tenants (tenant),
  id              BLOB NOT NULL CHECK (length(id) = 16),
  person          BLOB NOT NULL,
  station         BLOB NOT NULL,
  exercise        BLOB NOT NULL,
  profile_content BLOB NOT NULL CHECK (length(profile_content) = 32),
  state           INTEGER NOT NULL CHECK (state BETWEEN 1 AND 7),  -- 1 ticketed, 2 recording, 3 sealed, 4 scoring, 5 scored, 6 failed, 7 quarantined
  as_reference    INTEGER NOT NULL DEFAULT 0 CHECK (as_reference IN (0, 1)),
  released        INTEGER NOT NULL DEFAULT 0 CHECK (released IN (0, 1)),
  ticketed_ms     INTEGER NOT NULL,
  sealed_ms       INTEGER NOT NULL DEFAULT 0,
  ticket          BLOB NOT NULL,
  header          BLOB,
  head_hash       BLOB CHECK (length(head_hash) = 32),  -- of the header, then of the last chunk
  head_state_hash INTEGER NOT NULL DEFAULT 0,
  chunks          INTEGER NOT NULL DEFAULT 0,
  ticks           INTEGER NOT NULL DEFAULT 0,
  gap_ticks       INTEGER NOT NULL DEFAULT 0,
  trace_bytes     INTEGER NOT NULL DEFAULT 0,
  trace_blob      BLOB CHECK (length(trace_blob) = 32),  -- end of the trace file, mostly all of it, once sealed
  progress        REAL NOT NULL DEFAULT 0,
  problem         TEXT NOT NULL DEFAULT '',
  problem_field   TEXT NOT NULL DEFAULT '',  -- which problem: wire/README.md, "Refusals"
  score           REAL,
  critical_fail   INTEGER NOT NULL DEFAULT 0 CHECK (critical_fail IN (0, 1)),
  score_json      BLOB,
  final_volume    BLOB,
  deviation       BLOB,
  series          BLOB,
  reference       BLOB,  -- the attempt it was compared with
  expired_ms      INTEGER NOT NULL DEFAULT 0,
  assignment      BLOB CHECK (length(assignment) = 16),
  exam            INTEGER NOT NULL DEFAULT 0 CHECK (exam IN (0, 1)),
  due_ms          INTEGER NOT NULL DEFAULT 0,
  rate_hz         INTEGER NOT NULL DEFAULT 0,  -- 0: time is not checked
  limit_ticks     INTEGER NOT NULL DEFAULT 0,  -- 0: no time limit
  last_chunk_ms   INTEGER NOT NULL DEFAULT 0,  -- when the newest chunk came
  flags           INTEGER NOT NULL DEFAULT 0,
  override_score  REAL,
  override_reason TEXT NOT NULL DEFAULT '',
  override_by     BLOB CHECK (length(override_by) = 16),
  override_ms     INTEGER NOT NULL DEFAULT 0,
  revision        INTEGER NOT NULL DEFAULT 1,
  facts           TEXT NOT NULL DEFAULT '{}',
  hands           INTEGER NOT NULL DEFAULT 4,
  sign_off        INTEGER NOT NULL DEFAULT 0 CHECK (sign_off IN (0, 1)),
  hand_kind       INTEGER NOT NULL DEFAULT 0,
  hand_device     TEXT NOT NULL DEFAULT '',
  hand_driver     TEXT NOT NULL DEFAULT '',
  hand_unit       TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id),
  FOREIGN KEY (tenant, station) REFERENCES stations (tenant, id),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX attempts_by_person ON attempts (tenant, person, id);
CREATE INDEX attempts_by_exercise ON attempts (tenant, exercise, id);
CREATE INDEX attempts_by_reference ON attempts (tenant, reference) WHERE reference IS NOT NULL;
CREATE INDEX attempts_by_assignment ON attempts (tenant, assignment, id) WHERE assignment IS NOT NULL;
CREATE INDEX attempts_by_score ON attempts (tenant, coalesce(override_score, score, 1000.0), id DESC);

-- Who signed an exam attempt at its station: schemas/wire/README.md, "Sign-off".
CREATE TABLE sign_offs (
  tenant    INTEGER NOT NULL,
  attempt   BLOB NOT NULL,
  stage     TEXT NOT NULL CHECK (stage IN ('end', 'start')),
  signer    BLOB NOT NULL CHECK (length(signer) = 16),
  signed_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, attempt, stage),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;

CREATE TABLE trace_chunks (
  tenant      INTEGER NOT NULL,
  attempt     BLOB NOT NULL,
  seq         INTEGER NOT NULL,
  hash        BLOB NOT NULL CHECK (length(hash) = 32),
  bytes       BLOB NOT NULL,
  received_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, attempt, seq),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT;

-- The blobs before the last one, trace_blob, of a sealed recording that is larger than one: pieces of its trace file.
CREATE TABLE trace_parts (
  tenant     INTEGER NOT NULL,
  attempt    BLOB NOT NULL,
  next_chunk INTEGER NOT NULL,  -- number of the chunk that follows
  content    BLOB NOT NULL CHECK (length(content) = 32),
  PRIMARY KEY (tenant, attempt, next_chunk),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;

CREATE TABLE contradicting_chunks (
  tenant      INTEGER NOT NULL,
  attempt     BLOB NOT NULL,
  seq         INTEGER NOT NULL,
  hash        BLOB NOT NULL CHECK (length(hash) = 32),
  bytes       BLOB NOT NULL,
  received_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, attempt, seq, hash),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT;

CREATE TABLE reference_cuts (
  tenant       INTEGER NOT NULL,
  id           BLOB NOT NULL CHECK (length(id) = 16),
  exercise     BLOB NOT NULL,
  attempt      BLOB NOT NULL,
  dentist      TEXT NOT NULL,
  version      INTEGER NOT NULL,
  created_ms   INTEGER NOT NULL,
  consent      INTEGER NOT NULL DEFAULT 1 CHECK (consent IN (0, 1)),
  withdrawn_ms INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, exercise, version),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;

CREATE TABLE audit (
  tenant       INTEGER NOT NULL REFERENCES tenants (tenant),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  at_ms        INTEGER NOT NULL,
  actor        BLOB NOT NULL CHECK (length(actor) = 16),  -- zero: the system or the command line
  via          TEXT NOT NULL,
  action       TEXT NOT NULL,
  object       TEXT NOT NULL,
  before_json  TEXT NOT NULL,
  after_json   TEXT NOT NULL,
  subject      TEXT NOT NULL,
  state        TEXT NOT NULL,
  salt         BLOB CHECK (length(salt) = 32),  -- NULL: erased
  content_hash BLOB NOT NULL CHECK (length(content_hash) = 32),
  signature    BLOB NOT NULL CHECK (length(signature) = 64),
  chain        BLOB NOT NULL CHECK (length(chain) = 16),
  number       INTEGER NOT NULL CHECK (number > 0),
  previous     BLOB NOT NULL CHECK (length(previous) = 32),
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX audit_by_object ON audit (tenant, object, id);
CREATE INDEX audit_by_actor ON audit (tenant, actor, id);
CREATE INDEX audit_by_subject ON audit (tenant, subject, id) WHERE subject <> '';
CREATE UNIQUE INDEX audit_by_number ON audit (tenant, chain, number);

CREATE TABLE erasures (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  person_hash BLOB NOT NULL CHECK (length(person_hash) = 32),
  erased_ms   INTEGER NOT NULL,
  PRIMARY KEY (tenant, person_hash)
) STRICT, WITHOUT ROWID;

CREATE TABLE retention_rules (
  tenant INTEGER NOT NULL REFERENCES tenants (tenant),
  what   TEXT NOT NULL CHECK (what IN ('unfinished', 'recordings', 'attempts')),
  days   INTEGER NOT NULL CHECK (days BETWEEN 1 AND 36500),
  PRIMARY KEY (tenant, what)
) STRICT, WITHOUT ROWID;

CREATE TABLE assignments (
  tenant        INTEGER NOT NULL REFERENCES tenants (tenant),
  id            BLOB NOT NULL CHECK (length(id) = 16),
  exercise_name TEXT NOT NULL,
  cohort        BLOB NOT NULL CHECK (length(cohort) = 16),
  opens_ms      INTEGER NOT NULL DEFAULT 0 CHECK (opens_ms >= 0),
  due_ms        INTEGER NOT NULL DEFAULT 0 CHECK (due_ms >= 0),
  attempt_limit INTEGER NOT NULL DEFAULT 0 CHECK (attempt_limit >= 0),
  exam          INTEGER NOT NULL DEFAULT 0 CHECK (exam IN (0, 1)),
  late_allowed  INTEGER NOT NULL DEFAULT 0 CHECK (late_allowed IN (0, 1)),
  revision      INTEGER NOT NULL DEFAULT 1,
  created_ms    INTEGER NOT NULL DEFAULT 0,
  hands         INTEGER NOT NULL DEFAULT 4,
  exercise      BLOB NOT NULL CHECK (length(exercise) = 16),  -- the version
  counting      TEXT NOT NULL DEFAULT 'best' CHECK (counting IN ('best', 'last', 'mean', 'median')),
  sign_off      INTEGER NOT NULL DEFAULT 0 CHECK (sign_off IN (0, 1)),
  outline       TEXT NOT NULL DEFAULT 'practice' CHECK (outline IN ('practice', 'always', 'never')),
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX assignments_by_exercise ON assignments (tenant, exercise_name, cohort);
CREATE INDEX assignments_by_cohort ON assignments (tenant, cohort);

CREATE TABLE assignment_stations (
  tenant     INTEGER NOT NULL,
  assignment BLOB NOT NULL,
  station    BLOB NOT NULL,
  PRIMARY KEY (tenant, assignment, station),
  FOREIGN KEY (tenant, assignment) REFERENCES assignments (tenant, id) ON DELETE CASCADE,
  FOREIGN KEY (tenant, station) REFERENCES stations (tenant, id)
) STRICT, WITHOUT ROWID;

CREATE TABLE attempt_results (
  tenant                 INTEGER NOT NULL,
  attempt                BLOB NOT NULL,
  run                    INTEGER NOT NULL,
  scored_ms              INTEGER NOT NULL,
  cause                  TEXT NOT NULL,  -- of the job: "seal", "reference", "rescore", "appeal"
  score                  REAL NOT NULL,
  critical_fail          INTEGER NOT NULL CHECK (critical_fail IN (0, 1)),
  score_json             BLOB NOT NULL,
  reference              BLOB,  -- the attempt it was compared with
  replay_realtime_factor REAL NOT NULL DEFAULT 0,
  document               BLOB NOT NULL,  -- the signed result (schemas/result.md)
  final_volume           BLOB CHECK (length(final_volume) = 32),
  deviation              BLOB CHECK (length(deviation) = 32),
  series                 BLOB CHECK (length(series) = 32),
  PRIMARY KEY (tenant, attempt, run),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX attempt_results_by_reference ON attempt_results (tenant, reference) WHERE reference IS NOT NULL;

CREATE TABLE annotations (
  tenant       INTEGER NOT NULL,
  id           BLOB NOT NULL CHECK (length(id) = 16),
  attempt      BLOB NOT NULL,
  author       BLOB NOT NULL CHECK (length(author) = 16),
  tick         INTEGER NOT NULL CHECK (tick >= 0),
  x_um         INTEGER,
  y_um         INTEGER,
  z_um         INTEGER,
  text         TEXT NOT NULL,
  created_ms   INTEGER NOT NULL,
  edited_ms    INTEGER NOT NULL DEFAULT 0,
  revision     INTEGER NOT NULL DEFAULT 1,
  -- A remark to the chair (to_chair = 1): its number at its station, which grows with each remark of an attempt, and
  -- how far it has come.
  to_chair     INTEGER NOT NULL DEFAULT 0 CHECK (to_chair IN (0, 1)),
  remark_id    INTEGER CHECK (remark_id > 0),
  remark_state TEXT CHECK (remark_state IN ('waiting', 'sent', 'shown')),
  shown_ms     INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX annotations_by_attempt ON annotations (tenant, attempt, tick, id);
CREATE INDEX annotations_to_chairs ON annotations (tenant, created_ms) WHERE remark_id IS NOT NULL;

CREATE TABLE appeals (
  tenant      INTEGER NOT NULL,
  attempt     BLOB NOT NULL,
  filed_ms    INTEGER NOT NULL,
  text        TEXT NOT NULL,
  state       TEXT NOT NULL CHECK (state IN ('open', 'regraded', 'rejected')),
  answer      TEXT NOT NULL DEFAULT '',
  answered_by BLOB CHECK (length(answered_by) = 16),
  answered_ms INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX appeals_open ON appeals (tenant, filed_ms) WHERE state = 'open';

-- Blind marking: several people mark the attempts of an assignment without names and scores.
CREATE TABLE markings (
  tenant     INTEGER NOT NULL,
  id         BLOB NOT NULL CHECK (length(id) = 16),
  assignment BLOB NOT NULL,
  created_ms INTEGER NOT NULL,
  ended_ms   INTEGER NOT NULL DEFAULT 0 CHECK (ended_ms >= 0),  -- given up; 0: under way or done
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, assignment) REFERENCES assignments (tenant, id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;
CREATE INDEX markings_by_assignment ON markings (tenant, assignment);

CREATE TABLE marking_people (
  tenant  INTEGER NOT NULL,
  marking BLOB NOT NULL,
  person  BLOB NOT NULL CHECK (length(person) = 16),
  removed_ms INTEGER NOT NULL DEFAULT 0,  -- 0: marks
  PRIMARY KEY (tenant, marking, person),
  FOREIGN KEY (tenant, marking) REFERENCES markings (tenant, id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;
CREATE INDEX marking_people_by_person ON marking_people (tenant, person);

-- What markers see instead of the attempt's id.
CREATE TABLE marking_works (
  tenant  INTEGER NOT NULL,
  id      BLOB NOT NULL CHECK (length(id) = 16),
  marking BLOB NOT NULL,
  attempt BLOB NOT NULL,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, marking, attempt),
  FOREIGN KEY (tenant, marking) REFERENCES markings (tenant, id) ON DELETE CASCADE,
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX marking_works_by_attempt ON marking_works (tenant, attempt);

CREATE TABLE marks (
  tenant   INTEGER NOT NULL,
  work     BLOB NOT NULL,
  marker   BLOB NOT NULL CHECK (length(marker) = 16),
  rating   INTEGER NOT NULL CHECK (rating BETWEEN 1 AND 5),
  criteria TEXT NOT NULL,  -- JSON: [{"name", "points", "comment"}]
  made_ms  INTEGER NOT NULL,
  PRIMARY KEY (tenant, work, marker),
  FOREIGN KEY (tenant, work) REFERENCES marking_works (tenant, id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;
CREATE INDEX marks_by_marker ON marks (tenant, marker, made_ms);

CREATE TABLE jobs (
  tenant         INTEGER NOT NULL,
  id             BLOB NOT NULL CHECK (length(id) = 16),
  kind           TEXT NOT NULL,
  attempt        BLOB NOT NULL,
  cause          TEXT NOT NULL DEFAULT 'seal',
  state          TEXT NOT NULL CHECK (state IN ('queued', 'running', 'done', 'failed', 'cancelled')),
  tries          INTEGER NOT NULL DEFAULT 0,
  lease_until_ms INTEGER NOT NULL DEFAULT 0,
  error          TEXT NOT NULL DEFAULT '',
  batch          BLOB,  -- NULL: a run by itself, which goes first
  -- Names one run of the job. A worker gives it with everything it writes, so a worker whose lease ran out cannot
  -- change the run that another worker makes now. NULL: the job waits.
  lease          BLOB CHECK (length(lease) = 16),
  owner          BLOB CHECK (length(owner) = 16),  -- the server that holds the lease; NULL: the only one there is
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX jobs_open ON jobs (tenant, id) WHERE state IN ('queued', 'running');
CREATE INDEX jobs_by_attempt ON jobs (tenant, attempt, id);
CREATE INDEX jobs_by_batch ON jobs (tenant, batch) WHERE batch IS NOT NULL;
CREATE UNIQUE INDEX jobs_by_lease ON jobs (tenant, lease) WHERE lease IS NOT NULL;
-- One run of an attempt at a time.
CREATE UNIQUE INDEX jobs_running ON jobs (tenant, attempt) WHERE state = 'running';

CREATE TABLE sessions (
  tenant       INTEGER NOT NULL,
  token_hash   BLOB NOT NULL CHECK (length(token_hash) = 32),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  person       BLOB NOT NULL,
  created_ms   INTEGER NOT NULL,
  last_used_ms INTEGER NOT NULL,
  expires_ms   INTEGER NOT NULL,
  confirmed_ms INTEGER NOT NULL,
  via          TEXT NOT NULL,
  address      TEXT NOT NULL DEFAULT '',
  device       TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (tenant, token_hash),
  UNIQUE (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;
CREATE INDEX sessions_by_end ON sessions (tenant, expires_ms);
CREATE INDEX sessions_by_person ON sessions (tenant, person);

CREATE TABLE enrol_codes (
  tenant       INTEGER NOT NULL REFERENCES tenants (tenant),
  code_hash    BLOB NOT NULL CHECK (length(code_hash) = 32),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  created_ms   INTEGER NOT NULL,
  expires_ms   INTEGER NOT NULL,
  used_ms      INTEGER,
  withdrawn_ms INTEGER,
  PRIMARY KEY (tenant, code_hash),
  UNIQUE (tenant, id)
) STRICT, WITHOUT ROWID;

CREATE TABLE profile_versions (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  name       TEXT NOT NULL,
  version    INTEGER NOT NULL CHECK (version >= 1),
  title      TEXT NOT NULL,
  content    BLOB NOT NULL CHECK (length(content) = 32),
  created_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name, version)
) STRICT, WITHOUT ROWID;

CREATE TABLE profile_reports (
  tenant     INTEGER NOT NULL,
  id         BLOB NOT NULL CHECK (length(id) = 16),
  name       TEXT NOT NULL,
  version    INTEGER NOT NULL,
  media_type TEXT NOT NULL CHECK (media_type IN ('application/json', 'text/html')),
  content    BLOB NOT NULL CHECK (length(content) = 32),
  bytes      INTEGER NOT NULL,
  created_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name, version, content),
  FOREIGN KEY (tenant, name, version) REFERENCES profile_versions (tenant, name, version)
) STRICT, WITHOUT ROWID;

CREATE TABLE calibrations (
  tenant      INTEGER NOT NULL,
  id          BLOB NOT NULL CHECK (length(id) = 16),
  profile     TEXT NOT NULL,
  device      TEXT NOT NULL,
  measured_ms INTEGER NOT NULL,
  added_ms    INTEGER NOT NULL,
  document    TEXT NOT NULL,
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, profile) REFERENCES profiles (tenant, name)
) STRICT, WITHOUT ROWID;
CREATE UNIQUE INDEX calibrations_once ON calibrations (tenant, profile, document);
CREATE INDEX calibrations_by_profile ON calibrations (tenant, profile, measured_ms);

CREATE TABLE write_probe (
  tenant   INTEGER NOT NULL,
  server   BLOB NOT NULL CHECK (length(server) = 16),
  at_ms    INTEGER NOT NULL,  -- the database's clock
  ahead_ms INTEGER NOT NULL,  -- how far the server's own clock is ahead of it
  beats    INTEGER NOT NULL,  -- one more with each writing
  host     TEXT NOT NULL,     -- where its station link listens, numeric; empty: not known
  port     INTEGER NOT NULL,
  PRIMARY KEY (tenant, server)
) STRICT, WITHOUT ROWID;

CREATE TABLE rubrics (
  tenant       INTEGER NOT NULL,
  exercise     BLOB NOT NULL,  -- this version of it
  version      INTEGER NOT NULL CHECK (version > 1),  -- of the document, as scores name it
  content      BLOB NOT NULL CHECK (length(content) = 32),
  reason       TEXT NOT NULL,
  published_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, exercise, version),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id)
) STRICT, WITHOUT ROWID;

CREATE TABLE job_batches (
  tenant    INTEGER NOT NULL REFERENCES tenants (tenant),
  id        BLOB NOT NULL CHECK (length(id) = 16),
  title     TEXT NOT NULL,  -- for people: "Year 2, class-1-molar"
  cohort    BLOB,  -- whose attempts they are
  cause     TEXT NOT NULL,  -- of its jobs
  queued_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;

CREATE TABLE listed_devices (
  tenant   INTEGER NOT NULL REFERENCES tenants (tenant),
  name     TEXT NOT NULL,
  title    TEXT NOT NULL,  -- for people: "chair 3"
  added_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;

CREATE TABLE station_settings (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  name       TEXT NOT NULL,
  scope      TEXT NOT NULL,  -- '*': every station; 'lab2-*': those whose names begin so; else a name
  value      TEXT NOT NULL,
  fixed      INTEGER NOT NULL CHECK (fixed IN (0, 1)),  -- before a station's settings file
  changed_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name, scope)
) STRICT, WITHOUT ROWID;

-- What somebody says again and again in remarks, kept for that person.
CREATE TABLE saved_texts (
  tenant   INTEGER NOT NULL,
  id       BLOB NOT NULL CHECK (length(id) = 16),
  owner    BLOB NOT NULL,
  text     TEXT NOT NULL,
  shared   INTEGER NOT NULL CHECK (shared IN (0, 1)),  -- others who teach may use it
  saved_ms INTEGER NOT NULL,
  revision INTEGER NOT NULL DEFAULT 1,
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, owner) REFERENCES people (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX saved_texts_by_owner ON saved_texts (tenant, owner);
CREATE INDEX saved_texts_shared ON saved_texts (tenant) WHERE shared = 1;

CREATE TABLE exercise_owners (
  tenant INTEGER NOT NULL REFERENCES tenants (tenant),
  name   TEXT NOT NULL,
  owner  BLOB,  -- a person; NULL: the school's, hence the admins'
  shared INTEGER NOT NULL CHECK (shared IN (0, 1)),  -- other instructors may read and assign it
  PRIMARY KEY (tenant, name),
  FOREIGN KEY (tenant, owner) REFERENCES people (tenant, id)
) STRICT, WITHOUT ROWID;

CREATE TABLE timelines (
  tenant         INTEGER NOT NULL,
  attempt        BLOB NOT NULL,
  content        BLOB CHECK (length(content) = 32),  -- NULL: not made
  tries          INTEGER NOT NULL DEFAULT 0,  -- begun, of those that did not end with it
  problem        TEXT NOT NULL DEFAULT '',  -- why the last try failed
  owner          BLOB CHECK (length(owner) = 16),  -- the server that makes it
  lease_until_ms INTEGER NOT NULL DEFAULT 0,  -- no other server takes it until then
  asked_ms       INTEGER NOT NULL DEFAULT 0,  -- when somebody first wanted to see it and it was not made; 0: nobody did
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX timelines_to_make ON timelines (tenant, attempt) WHERE content IS NULL;

CREATE TABLE start_teeth (
  tenant  INTEGER NOT NULL REFERENCES tenants (tenant),
  volume  BLOB NOT NULL CHECK (length(volume) = 32),
  content BLOB NOT NULL CHECK (length(content) = 32),
  PRIMARY KEY (tenant, volume)
) STRICT, WITHOUT ROWID;
CREATE INDEX start_teeth_by_content ON start_teeth (tenant, content);

CREATE TABLE motions (
  tenant     INTEGER NOT NULL,
  attempt    BLOB NOT NULL,
  content    BLOB NOT NULL CHECK (length(content) = 32),
  nearest    BLOB CHECK (length(nearest) = 16),  -- an attempt; NULL: there was none before it, or it is erased
  others     INTEGER NOT NULL,  -- it was compared with so many
  nearest_um INTEGER NOT NULL,
  median_um  INTEGER NOT NULL,
  size_um    INTEGER NOT NULL,
  preset     BLOB CHECK (length(preset) = 16),  -- the nearest reference or simulated hand; NULL: as nearest
  presets    INTEGER NOT NULL,
  preset_um  INTEGER NOT NULL,
  tremor_nm  INTEGER NOT NULL,  -- of the hand: schemas/motion.md, "Hand"
  still_ppm  INTEGER NOT NULL,
  late_ppm   INTEGER NOT NULL,
  gap_ppm    INTEGER NOT NULL,
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX motions_by_nearest ON motions (tenant, nearest) WHERE nearest IS NOT NULL;
CREATE INDEX motions_by_preset ON motions (tenant, preset) WHERE preset IS NOT NULL;

CREATE TABLE audit_heads (
  tenant    INTEGER NOT NULL,
  chain     BLOB NOT NULL CHECK (length(chain) = 16),
  number    INTEGER NOT NULL CHECK (number > 0),  -- of its last row
  last_id   BLOB NOT NULL CHECK (length(last_id) = 16),
  hash      BLOB NOT NULL CHECK (length(hash) = 32),
  signature BLOB NOT NULL CHECK (length(signature) = 64),
  PRIMARY KEY (tenant, chain)
) STRICT, WITHOUT ROWID;

-- Blobs in an S3 store; empty where blobs are files. A row is added after its object and deleted before it. The
-- transaction that deletes a row sees that no other row names the blob. A transaction that names a blob which may go
-- with its attempt changes the blob's row too.
CREATE TABLE blobs (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  hash       BLOB NOT NULL CHECK (length(hash) = 32),  -- SHA-256 of the bytes: the blob's name
  bytes      INTEGER NOT NULL CHECK (bytes >= 0),        -- its size: no more is read
  generation INTEGER NOT NULL CHECK (generation > 0),    -- at random; the object is <hash>-<generation>
  put_ms     INTEGER NOT NULL,                           -- the last time that somebody put or named it
  PRIMARY KEY (tenant, hash)
) STRICT, WITHOUT ROWID;

-- Keys in an S3 store (schemas/personal_data.md, "Keys in a bucket"); empty where the key ring is a folder. A row is
-- added after its object, and deleted after it, by an erasure that has put the person among the erased before.
CREATE TABLE person_keys (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  person     BLOB NOT NULL CHECK (length(person) = 16),
  generation INTEGER NOT NULL CHECK (generation > 0),    -- at random; the object is <uuid>-<generation>
  hash       BLOB NOT NULL CHECK (length(hash) = 32),  -- SHA-256 of the object
  made_ms    INTEGER NOT NULL,
  PRIMARY KEY (tenant, person)
) STRICT, WITHOUT ROWID;

-- SHA-256 of what all servers of this database must have in common. The first server writes it; a server that has
-- something else is refused. Empty where only one server can have its rows here.
CREATE TABLE server_identity (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  name        TEXT NOT NULL CHECK (name IN ('station_certificate', 'ticket_key', 'key_ring')),
  fingerprint BLOB NOT NULL CHECK (length(fingerprint) = 32),
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;

-- Failures to sign in, counted by all servers together. `key` is a hash under a key of the school's, because people
-- type passwords into the login field. PostgreSQL does not log this table, so counting begins again after its crash
-- and on a standby that takes over.
CREATE TABLE sign_in_counters (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  key         BLOB NOT NULL CHECK (length(key) = 32),
  failures    INTEGER NOT NULL CHECK (failures >= 0),
  first_tries INTEGER NOT NULL CHECK (first_tries >= 0),
  last_ms     INTEGER NOT NULL,
  next_try_ms INTEGER NOT NULL,
  until_ms    INTEGER NOT NULL,  -- forgotten then
  PRIMARY KEY (tenant, key)
) STRICT, WITHOUT ROWID;
CREATE INDEX sign_in_counters_by_end ON sign_in_counters (tenant, until_ms);

-- Work that only one server does at a time. A lease ends at until_ms, or when its holder deletes the row.
CREATE TABLE leases (
  tenant   INTEGER NOT NULL REFERENCES tenants (tenant),
  name     TEXT NOT NULL CHECK (name IN ('upkeep')),
  lease    BLOB NOT NULL CHECK (length(lease) = 16),  -- of this holding of it
  until_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;

-- A row while an erasure may have left copies of what it deleted: the tables have to be rewritten.
CREATE TABLE rewrite_due (
  tenant   INTEGER NOT NULL PRIMARY KEY REFERENCES tenants (tenant),
  since_ms INTEGER NOT NULL,
  mark     BLOB NOT NULL CHECK (length(mark) = 16)  -- of whoever erased last
) STRICT;

-- Running servers, each with a new id for each run, and the stations connected to them. A server that was not heard for
-- a while is gone. PostgreSQL does not log these tables: each server writes its rows again.
CREATE TABLE running_servers (
  tenant   INTEGER NOT NULL REFERENCES tenants (tenant),
  server   BLOB NOT NULL CHECK (length(server) = 16),
  heard_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, server)
) STRICT, WITHOUT ROWID;
CREATE TABLE station_links (
  tenant        INTEGER NOT NULL REFERENCES tenants (tenant),
  server        BLOB NOT NULL CHECK (length(server) = 16),
  station       BLOB NOT NULL CHECK (length(station) = 16),
  shows_remarks INTEGER NOT NULL CHECK (shows_remarks IN (0, 1)),
  PRIMARY KEY (tenant, server, station)
) STRICT, WITHOUT ROWID;

-- Other schools of this installation (schemas/schools.md); empty where the server is one school's.
CREATE TABLE schools (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  name       TEXT NOT NULL,
  id         BLOB NOT NULL CHECK (length(id) = 16),
  hosts      TEXT NOT NULL,  -- lower case, without port, one space between two
  state      TEXT NOT NULL CHECK (state IN ('being_made', 'served', 'suspended', 'being_deleted')),
  created_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;

-- The school was moved out of this database, or is being moved into it and is half here. For servers whose folders have
-- no mark of the move.
CREATE TABLE move_marks (
  tenant INTEGER NOT NULL REFERENCES tenants (tenant),
  mark   TEXT NOT NULL CHECK (mark IN ('moved', 'moving')),
  PRIMARY KEY (tenant, mark)
) STRICT, WITHOUT ROWID;

-- For SQLite alone, from here on.

CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
BEGIN
  SELECT RAISE(ABORT, 'audit rows are never deleted');
END;

-- Rows never change, except that erasing a person blanks the words of rows about that person.
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
WHEN NOT (
  NEW.tenant = OLD.tenant AND NEW.id = OLD.id AND NEW.at_ms = OLD.at_ms AND NEW.actor = OLD.actor AND
  NEW.via = OLD.via AND NEW.action = OLD.action AND NEW.object = OLD.object AND NEW.subject = OLD.subject AND
  NEW.content_hash = OLD.content_hash AND NEW.signature = OLD.signature AND NEW.chain = OLD.chain AND
  NEW.number = OLD.number AND NEW.previous = OLD.previous AND NEW.salt IS NULL AND
  NEW.state = CASE OLD.state WHEN '' THEN '' ELSE '{"erased":true}' END AND
  NEW.before_json = '{"erased":true}' AND NEW.after_json = '{"erased":true}' AND (
    ((OLD.action LIKE 'person.%' OR OLD.action LIKE 'session.%' OR OLD.action = 'request.refused') AND
     NOT EXISTS (SELECT 1 FROM people p WHERE p.tenant = OLD.tenant AND
                 lower(hex(p.id)) = replace(OLD.object, '-', ''))) OR
    (OLD.action <> 'attempt.ticket' AND
     EXISTS (SELECT 1 FROM audit t WHERE t.tenant = OLD.tenant AND t.object = OLD.object AND
             t.action = 'attempt.ticket' AND
             replace(json_extract(t.after_json, '$.person'), '-', '') NOT IN
               (SELECT lower(hex(p.id)) FROM people p WHERE p.tenant = OLD.tenant)))))
BEGIN
  SELECT RAISE(ABORT, 'audit rows are never changed');
END;

CREATE TRIGGER audit_heads_are_not_deleted BEFORE DELETE ON audit_heads
BEGIN
  SELECT RAISE(ABORT, 'the audit trail only grows');
END;
CREATE TRIGGER audit_heads_only_advance BEFORE UPDATE ON audit_heads
WHEN NOT (NEW.tenant = OLD.tenant AND NEW.chain = OLD.chain AND NEW.number > OLD.number)
BEGIN
  SELECT RAISE(ABORT, 'the audit trail only grows');
END;

-- The planner's statistics are a school's of 5 000 people and 20 000 attempts, in every file and for good, so that plans
-- depend on no data. Not PRAGMA optimize: with its limit, ANALYZE reads only the first rows of an index, and takes the
-- tenant, the same in every row, for selective; a full ANALYZE reads whole tables. A new index needs its line; a test
-- (tests/server/storage/plans.py) looks at the plans of all statements.
ANALYZE sqlite_schema;
INSERT INTO sqlite_stat1 (tbl, idx, stat) VALUES
  ('annotations', 'annotations', '10000 10000 1'),
  ('annotations', 'annotations_by_attempt', '10000 10000 1 1 1'),
  ('annotations', 'annotations_to_chairs', '1000 1000 1'),
  ('appeals', 'appeals', '200 200 1'),
  ('appeals', 'appeals_open', '9 9 1'),
  ('assignment_stations', 'assignment_stations', '200 200 1 1'),
  ('assignments', 'assignments', '2000 2000 1'),
  ('assignments', 'assignments_by_cohort', '2000 2000 10'),
  ('assignments', 'assignments_by_exercise', '2000 2000 100 5'),
  ('attempt_results', 'attempt_results', '20000 20000 1 1'),
  ('attempt_results', 'attempt_results_by_reference', '6667 6667 84'),
  ('attempts', 'attempts', '20000 20000 1'),
  ('attempts', 'attempts_by_assignment', '15000 15000 100 1'),
  ('attempts', 'attempts_by_exercise', '20000 20000 250 1'),
  ('attempts', 'attempts_by_person', '20000 20000 5 1'),
  ('attempts', 'attempts_by_reference', '6667 6667 84'),
  ('attempts', 'attempts_by_score', '20000 20000 20 1'),
  ('audit', 'audit', '60000 60000 1'),
  ('audit', 'audit_by_actor', '60000 60000 12 1'),
  ('audit', 'audit_by_number', '60000 60000 60000 1'),
  ('audit', 'audit_by_object', '60000 60000 3 1'),
  ('audit', 'audit_by_subject', '30000 30000 4 1'),
  ('audit_heads', 'audit_heads', '1 1 1'),
  ('blobs', 'blobs', '20000 20000 1'),
  ('calibrations', 'calibrations', '200 200 1'),
  ('calibrations', 'calibrations_by_profile', '200 200 20 1'),
  ('calibrations', 'calibrations_once', '200 200 20 1'),
  ('cohort_members', 'cohort_members', '5988 5988 30 1'),
  ('cohort_members', 'cohort_members_by_person', '5988 5988 2'),
  ('cohorts', 'cohorts', '200 200 1'),
  ('cohorts', 'sqlite_autoindex_cohorts_2', '200 200 1'),
  ('contradicting_chunks', 'sqlite_autoindex_contradicting_chunks_1', '100 100 1 1 1'),
  ('enrol_codes', 'enrol_codes', '100 100 1'),
  ('enrol_codes', 'sqlite_autoindex_enrol_codes_2', '100 100 1'),
  ('erasures', 'erasures', '200 200 1'),
  ('exercise_owners', 'exercise_owners', '20 20 1'),
  ('exercises', 'exercises', '80 80 1'),
  ('exercises', 'exercises_by_content', '80 80 1'),
  ('exercises', 'sqlite_autoindex_exercises_2', '80 80 4 1'),
  ('job_batches', 'job_batches', '200 200 1'),
  ('jobs', 'jobs', '20000 20000 1'),
  ('jobs', 'jobs_by_attempt', '20000 20000 1 1'),
  ('jobs', 'jobs_by_batch', '2000 2000 10'),
  ('jobs', 'jobs_by_lease', '4 4 1'),
  ('jobs', 'jobs_open', '19 19 1'),
  ('jobs', 'jobs_running', '4 4 1'),
  ('leases', 'leases', '1 1 1'),
  ('listed_devices', 'listed_devices', '100 100 1'),
  ('marking_people', 'marking_people', '200 200 2 1'),
  ('marking_people', 'marking_people_by_person', '200 200 1'),
  ('marking_works', 'marking_works', '2000 2000 1'),
  ('marking_works', 'marking_works_by_attempt', '2000 2000 1'),
  ('marking_works', 'sqlite_autoindex_marking_works_2', '2000 2000 20 1'),
  ('markings', 'markings', '100 100 1'),
  ('markings', 'markings_by_assignment', '100 100 1'),
  ('marks', 'marks', '2000 2000 1 1'),
  ('marks', 'marks_by_marker', '2000 2000 10 1'),
  ('motions', 'motions', '20000 20000 1'),
  ('motions', 'motions_by_nearest', '20000 20000 2'),
  ('motions', 'motions_by_preset', '20000 20000 200'),
  ('move_marks', 'move_marks', '1 1 1'),
  ('people', 'people', '5000 5000 1'),
  ('people', 'people_by_name', '5000 5000 1 1'),
  ('people', 'people_by_role', '5000 5000 1700 1'),
  ('people', 'sqlite_autoindex_people_2', '5000 5000 1'),
  ('person_keys', 'person_keys', '5000 5000 1'),
  ('profile_reports', 'profile_reports', '100 100 1'),
  ('profile_reports', 'sqlite_autoindex_profile_reports_2', '100 100 10 1 1'),
  ('profile_versions', 'profile_versions', '100 100 10 1'),
  ('profiles', 'profiles', '10 10 1'),
  ('reference_cuts', 'reference_cuts', '80 80 1'),
  ('reference_cuts', 'sqlite_autoindex_reference_cuts_2', '80 80 1 1'),
  ('retention_rules', 'retention_rules', '3 3 1'),
  ('rewrite_due', NULL, '1'),
  ('rubrics', 'rubrics', '40 40 1 1'),
  ('running_servers', 'running_servers', '2 2 1'),
  ('saved_texts', 'saved_texts', '1000 1000 1'),
  ('saved_texts', 'saved_texts_by_owner', '1000 1000 20'),
  ('saved_texts', 'saved_texts_shared', '100 100'),
  ('scenes', 'scenes', '1 1 1'),
  ('schools', 'schools', '10 10 1'),
  ('server_identity', 'server_identity', '3 3 1'),
  ('sessions', 'sessions', '2000 2000 1'),
  ('sessions', 'sessions_by_end', '2000 2000 1'),
  ('sessions', 'sessions_by_person', '2000 2000 1'),
  ('sessions', 'sqlite_autoindex_sessions_2', '2000 2000 1'),
  ('sign_in_counters', 'sign_in_counters', '1000 1000 1'),
  ('sign_in_counters', 'sign_in_counters_by_end', '1000 1000 1'),
  ('sign_offs', 'sign_offs', '2000 2000 1 1'),
  ('start_teeth', 'start_teeth', '40 40 1'),
  ('start_teeth', 'start_teeth_by_content', '40 40 1'),
  ('station_links', 'station_links', '100 100 50 1'),
  ('station_settings', 'station_settings', '20 20 1 1'),
  ('stations', 'stations', '100 100 1'),
  ('tenants', NULL, '1'),
  ('timelines', 'timelines', '20000 20000 1'),
  ('timelines', 'timelines_to_make', '50 50 1'),
  ('trace_chunks', 'sqlite_autoindex_trace_chunks_1', '20000 20000 200 1'),
  ('trace_parts', 'trace_parts', '1000 1000 10 1'),
  ('write_probe', 'write_probe', '2 2 1');
ANALYZE sqlite_schema;
