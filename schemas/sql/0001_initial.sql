-- Schema 1 of the server's store. Migrations are numbered and forward-only; each runs in one
-- transaction. Shaped so that it can move to PostgreSQL: the tenant leads every key, ids are UUIDv7
-- (16 bytes, sort by age), times are milliseconds since the Unix epoch, hashes are SHA-256 (32 bytes).
-- What is large lives in content-addressed blobs and is named here by its hash.

CREATE TABLE tenants (
  tenant INTEGER NOT NULL PRIMARY KEY,
  name   TEXT NOT NULL
) STRICT;
INSERT INTO tenants (tenant, name) VALUES (1, 'default');

CREATE TABLE people (
  tenant       INTEGER NOT NULL REFERENCES tenants (tenant),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  login        TEXT NOT NULL,
  display_name TEXT NOT NULL,
  role         INTEGER NOT NULL CHECK (role BETWEEN 1 AND 3),  -- 1 student, 2 instructor, 3 admin
  disabled     INTEGER NOT NULL DEFAULT 0 CHECK (disabled IN (0, 1)),
  created_ms   INTEGER NOT NULL,
  verifier     TEXT NOT NULL,                                  -- argon2id, libsodium's form
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, login)
) STRICT, WITHOUT ROWID;

CREATE TABLE sessions (
  tenant       INTEGER NOT NULL,
  token_hash   BLOB NOT NULL CHECK (length(token_hash) = 32),
  person       BLOB NOT NULL,
  created_ms   INTEGER NOT NULL,
  last_used_ms INTEGER NOT NULL,
  expires_ms   INTEGER NOT NULL,
  via          TEXT NOT NULL,
  PRIMARY KEY (tenant, token_hash),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;
CREATE INDEX sessions_by_person ON sessions (tenant, person);

CREATE TABLE cohorts (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  id         BLOB NOT NULL CHECK (length(id) = 16),
  name       TEXT NOT NULL,
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

CREATE TABLE enrol_codes (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  code_hash  BLOB NOT NULL CHECK (length(code_hash) = 32),
  expires_ms INTEGER NOT NULL,
  used_ms    INTEGER,
  PRIMARY KEY (tenant, code_hash)
) STRICT, WITHOUT ROWID;

CREATE TABLE stations (
  tenant          INTEGER NOT NULL REFERENCES tenants (tenant),
  id              BLOB NOT NULL CHECK (length(id) = 16),
  name            TEXT NOT NULL,
  public_key      BLOB NOT NULL CHECK (length(public_key) = 32),  -- Ed25519, checks chunks
  credential_hash BLOB NOT NULL CHECK (length(credential_hash) = 32),
  revoked         INTEGER NOT NULL DEFAULT 0 CHECK (revoked IN (0, 1)),
  enrolled_ms     INTEGER NOT NULL,
  last_seen_ms    INTEGER NOT NULL,
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
  PRIMARY KEY (tenant, content)
) STRICT, WITHOUT ROWID;

-- One row per version; the newest of a name is the one offered.
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
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name, version),
  FOREIGN KEY (tenant, scene) REFERENCES scenes (tenant, content)
) STRICT, WITHOUT ROWID;
CREATE INDEX exercises_by_content ON exercises (tenant, content);

-- Who may do an exercise, by its name, all versions. A zero cohort (16 zero bytes): everybody.
CREATE TABLE assignments (
  tenant        INTEGER NOT NULL REFERENCES tenants (tenant),
  exercise_name TEXT NOT NULL,
  cohort        BLOB NOT NULL CHECK (length(cohort) = 16),
  PRIMARY KEY (tenant, exercise_name, cohort)
) STRICT, WITHOUT ROWID;

CREATE TABLE attempts (
  tenant          INTEGER NOT NULL REFERENCES tenants (tenant),
  id              BLOB NOT NULL CHECK (length(id) = 16),
  person          BLOB NOT NULL,
  station         BLOB NOT NULL,
  exercise        BLOB NOT NULL,
  profile_content BLOB NOT NULL CHECK (length(profile_content) = 32),
  -- 1 ticketed, 2 recording, 3 sealed, 4 scoring, 5 scored, 6 failed, 7 quarantined
  state           INTEGER NOT NULL CHECK (state BETWEEN 1 AND 7),
  as_reference    INTEGER NOT NULL DEFAULT 0 CHECK (as_reference IN (0, 1)),
  released        INTEGER NOT NULL DEFAULT 0 CHECK (released IN (0, 1)),
  ticketed_ms     INTEGER NOT NULL,
  sealed_ms       INTEGER NOT NULL DEFAULT 0,
  ticket          BLOB NOT NULL,
  header          BLOB,
  -- The committed chain: what the next chunk must continue.
  head_hash       BLOB CHECK (length(head_hash) = 32),     -- of the header, then of the last chunk
  head_state_hash INTEGER NOT NULL DEFAULT 0,
  chunks          INTEGER NOT NULL DEFAULT 0,
  ticks           INTEGER NOT NULL DEFAULT 0,
  gap_ticks       INTEGER NOT NULL DEFAULT 0,
  trace_bytes     INTEGER NOT NULL DEFAULT 0,
  trace_blob      BLOB CHECK (length(trace_blob) = 32),    -- whole trace file, once sealed
  -- What scoring left.
  progress        REAL NOT NULL DEFAULT 0,
  problem         TEXT NOT NULL DEFAULT '',
  score           REAL,
  critical_fail   INTEGER NOT NULL DEFAULT 0 CHECK (critical_fail IN (0, 1)),
  score_json      BLOB,
  final_volume    BLOB,
  surface         BLOB,
  series          BLOB,
  reference       BLOB,                                    -- the attempt it was compared with
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id),
  FOREIGN KEY (tenant, station) REFERENCES stations (tenant, id),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX attempts_by_person ON attempts (tenant, person, id);
CREATE INDEX attempts_by_exercise ON attempts (tenant, exercise, id);

-- Chunks of attempts that are not sealed yet.
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

-- Evidence of quarantine: chunks that contradict a committed one. At most 16 per attempt are kept.
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

-- Reference cuts; the newest version of an exercise counts.
CREATE TABLE reference_cuts (
  tenant     INTEGER NOT NULL,
  id         BLOB NOT NULL CHECK (length(id) = 16),
  exercise   BLOB NOT NULL,
  attempt    BLOB NOT NULL,
  dentist    TEXT NOT NULL,
  version    INTEGER NOT NULL,
  created_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, exercise, version),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;

-- Leases: a running job whose lease ran out may be taken again.
CREATE TABLE jobs (
  tenant         INTEGER NOT NULL,
  id             BLOB NOT NULL CHECK (length(id) = 16),
  kind           TEXT NOT NULL,
  attempt        BLOB NOT NULL,
  state          TEXT NOT NULL CHECK (state IN ('queued', 'running', 'done', 'failed')),
  tries          INTEGER NOT NULL DEFAULT 0,
  lease_until_ms INTEGER NOT NULL DEFAULT 0,
  error          TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX jobs_open ON jobs (tenant, id) WHERE state IN ('queued', 'running');

-- Who changed what. Pseudonymous: ids, no names.
CREATE TABLE audit (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  id          BLOB NOT NULL CHECK (length(id) = 16),
  at_ms       INTEGER NOT NULL,
  actor       BLOB NOT NULL CHECK (length(actor) = 16),    -- zero: the system or the command line
  via         TEXT NOT NULL,
  action      TEXT NOT NULL,
  object      TEXT NOT NULL,
  before_json TEXT NOT NULL,
  after_json  TEXT NOT NULL,
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;
