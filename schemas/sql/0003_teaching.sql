-- Schema 3: exercises as drafts, published and retired versions; assignments with dates, limits and
-- exams; what came of an attempt besides its score: overrides, annotations, appeals, earlier results.

-- One draft per name, as version 0; publishing gives it the next number and it never changes again.
ALTER TABLE exercises ADD COLUMN state INTEGER NOT NULL DEFAULT 2
  CHECK (state BETWEEN 1 AND 3);                                  -- 1 draft, 2 published, 3 retired
ALTER TABLE exercises ADD COLUMN revision INTEGER NOT NULL DEFAULT 1;  -- counts the changes of a draft

-- The picture of the scene before anything is cut (format ENSF); NULL: not made yet.
ALTER TABLE scenes ADD COLUMN surface BLOB CHECK (length(surface) = 32);

-- Who may do an exercise, by its name: the newest published version counts. A zero cohort (16 zero
-- bytes): everybody. Times 0: no such bound; attempt_limit 0: as many as wanted.
CREATE TABLE assignments_3 (
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
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO assignments_3 (tenant, id, exercise_name, cohort)
  SELECT tenant, randomblob(16), exercise_name, cohort FROM assignments;
DROP TABLE assignments;
ALTER TABLE assignments_3 RENAME TO assignments;
CREATE INDEX assignments_by_exercise ON assignments (tenant, exercise_name, cohort);

-- Where an exam is taken; no rows: anywhere.
CREATE TABLE assignment_stations (
  tenant     INTEGER NOT NULL,
  assignment BLOB NOT NULL,
  station    BLOB NOT NULL,
  PRIMARY KEY (tenant, assignment, station),
  FOREIGN KEY (tenant, assignment) REFERENCES assignments (tenant, id) ON DELETE CASCADE,
  FOREIGN KEY (tenant, station) REFERENCES stations (tenant, id)
) STRICT, WITHOUT ROWID;

-- The terms an attempt was begun under, as they were then; the assignment may change or go.
ALTER TABLE attempts ADD COLUMN assignment BLOB CHECK (length(assignment) = 16);
ALTER TABLE attempts ADD COLUMN exam INTEGER NOT NULL DEFAULT 0 CHECK (exam IN (0, 1));
ALTER TABLE attempts ADD COLUMN due_ms INTEGER NOT NULL DEFAULT 0;
ALTER TABLE attempts ADD COLUMN rate_hz INTEGER NOT NULL DEFAULT 0;      -- 0: time is not checked
ALTER TABLE attempts ADD COLUMN limit_ticks INTEGER NOT NULL DEFAULT 0;  -- 0: no time limit
ALTER TABLE attempts ADD COLUMN last_chunk_ms INTEGER NOT NULL DEFAULT 0;  -- when the newest chunk came
-- Bits: 1 late, 2 late_upload, 4 faster_than_time, 8 over_time, 16 resumed, 32 excused, 64 readmitted
ALTER TABLE attempts ADD COLUMN flags INTEGER NOT NULL DEFAULT 0;
CREATE INDEX attempts_by_assignment ON attempts (tenant, assignment, person) WHERE assignment IS NOT NULL;

-- What an instructor says the score is; the computed one stays in `score`.
ALTER TABLE attempts ADD COLUMN override_score REAL;
ALTER TABLE attempts ADD COLUMN override_reason TEXT NOT NULL DEFAULT '';
ALTER TABLE attempts ADD COLUMN override_by BLOB CHECK (length(override_by) = 16);
ALTER TABLE attempts ADD COLUMN override_ms INTEGER NOT NULL DEFAULT 0;

-- Every scoring run of an attempt; the newest is also in `attempts`.
CREATE TABLE attempt_results (
  tenant        INTEGER NOT NULL,
  attempt       BLOB NOT NULL,
  run           INTEGER NOT NULL,
  scored_ms     INTEGER NOT NULL,
  cause         TEXT NOT NULL,   -- of the job: "seal", "reference", "rescore", "appeal"
  score         REAL NOT NULL,
  critical_fail INTEGER NOT NULL CHECK (critical_fail IN (0, 1)),
  score_json    BLOB NOT NULL,
  reference     BLOB,            -- the attempt it was compared with
  PRIMARY KEY (tenant, attempt, run),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO attempt_results (tenant, attempt, run, scored_ms, cause, score, critical_fail, score_json, reference)
  SELECT tenant, id, 1, sealed_ms, 'seal', score, critical_fail, score_json, reference FROM attempts
  WHERE score IS NOT NULL AND score_json IS NOT NULL;

-- Remarks at a moment of an attempt and, where the columns are not NULL, at a point of the scene.
CREATE TABLE annotations (
  tenant     INTEGER NOT NULL,
  id         BLOB NOT NULL CHECK (length(id) = 16),
  attempt    BLOB NOT NULL,
  author     BLOB NOT NULL CHECK (length(author) = 16),
  tick       INTEGER NOT NULL CHECK (tick >= 0),
  x_um       INTEGER,
  y_um       INTEGER,
  z_um       INTEGER,
  text       TEXT NOT NULL,
  created_ms INTEGER NOT NULL,
  edited_ms  INTEGER NOT NULL DEFAULT 0,
  revision   INTEGER NOT NULL DEFAULT 1,
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
CREATE INDEX annotations_by_attempt ON annotations (tenant, attempt, tick, id);

-- At most one appeal per attempt.
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

-- A withdrawn reference no longer counts; the one before it does again.
ALTER TABLE reference_cuts ADD COLUMN consent INTEGER NOT NULL DEFAULT 1
  CHECK (consent IN (0, 1));                              -- the dentist's name may be shown to students
ALTER TABLE reference_cuts ADD COLUMN withdrawn_ms INTEGER NOT NULL DEFAULT 0;

-- Jobs can be cancelled, and say why they run.
CREATE TABLE jobs_3 (
  tenant         INTEGER NOT NULL,
  id             BLOB NOT NULL CHECK (length(id) = 16),
  kind           TEXT NOT NULL,
  attempt        BLOB NOT NULL,
  cause          TEXT NOT NULL DEFAULT 'seal',
  state          TEXT NOT NULL CHECK (state IN ('queued', 'running', 'done', 'failed', 'cancelled')),
  tries          INTEGER NOT NULL DEFAULT 0,
  lease_until_ms INTEGER NOT NULL DEFAULT 0,
  error          TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO jobs_3 (tenant, id, kind, attempt, state, tries, lease_until_ms, error)
  SELECT tenant, id, kind, attempt, state, tries, lease_until_ms, error FROM jobs;
DROP TABLE jobs;
ALTER TABLE jobs_3 RENAME TO jobs;
CREATE INDEX jobs_open ON jobs (tenant, id) WHERE state IN ('queued', 'running');
CREATE INDEX jobs_by_attempt ON jobs (tenant, attempt, id);
