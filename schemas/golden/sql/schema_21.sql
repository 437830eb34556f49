-- A database of schema 21 with something in every table but audit_heads, as `.dump` writes it: schema_20.sql, migrated,
-- with a counter, a lease and an erasure whose copies are due. What is signed there only the server that did it can have
-- signed: tests/server/storage/verify_trail_test.cpp has that.
-- Loaded, migrated and read by tests/server/storage/migration_test.cpp. Never changed.
PRAGMA application_id = 0x456e6d6c;
PRAGMA user_version = 21;
PRAGMA foreign_keys=OFF;
BEGIN TRANSACTION;
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
  reference       BLOB, expired_ms INTEGER NOT NULL DEFAULT 0, assignment BLOB CHECK (length(assignment) = 16), exam INTEGER NOT NULL DEFAULT 0 CHECK (exam IN (0, 1)), due_ms INTEGER NOT NULL DEFAULT 0, rate_hz INTEGER NOT NULL DEFAULT 0, limit_ticks INTEGER NOT NULL DEFAULT 0, last_chunk_ms INTEGER NOT NULL DEFAULT 0, flags INTEGER NOT NULL DEFAULT 0, override_score REAL, override_reason TEXT NOT NULL DEFAULT '', override_by BLOB CHECK (length(override_by) = 16), override_ms INTEGER NOT NULL DEFAULT 0, revision INTEGER NOT NULL DEFAULT 1, facts TEXT NOT NULL DEFAULT '{}', hands INTEGER NOT NULL DEFAULT 4, hand_kind INTEGER NOT NULL DEFAULT 0, hand_device TEXT NOT NULL DEFAULT '', hand_driver TEXT NOT NULL DEFAULT '', hand_unit TEXT NOT NULL DEFAULT '',                                    -- the attempt it was compared with
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id),
  FOREIGN KEY (tenant, station) REFERENCES stations (tenant, id),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO attempts VALUES(1,X'01890a5dac96774bbcceb30200000028',X'01890a5dac96774bbcceb30200000002',X'01890a5dac96774bbcceb30200000014',X'01890a5dac96774bbcceb3020000001e',X'1900eab6c028483d7126599ee6f50de0d27907b5c65fa90524580b4b0f9852b0',1,0,0,3000,0,X'7469636b6574',NULL,NULL,0,0,0,0,0,NULL,0.0,'',NULL,0,NULL,NULL,NULL,NULL,NULL,0,NULL,0,0,0,0,0,0,NULL,'',NULL,0,1,'{}',4,0,'','','');
INSERT INTO attempts VALUES(1,X'01890a5dac96774bbcceb30200000029',X'01890a5dac96774bbcceb30200000002',X'01890a5dac96774bbcceb30200000014',X'01890a5dac96774bbcceb3020000001e',X'1900eab6c028483d7126599ee6f50de0d27907b5c65fa90524580b4b0f9852b0',2,0,0,3100,0,X'7469636b6574',X'686561646572206f662061207265636f7264696e67',X'1993a3c633cf3e4fd898beaccbf56c1544235cd8f97396e3cbe30952502a5167',-5,2,500,3,90,NULL,0.0,'',NULL,0,NULL,NULL,NULL,NULL,NULL,0,NULL,0,0,0,0,0,0,NULL,'',NULL,0,1,'{}',4,0,'','','');
INSERT INTO attempts VALUES(1,X'01890a5dac96774bbcceb3020000002a',X'01890a5dac96774bbcceb30200000001',X'01890a5dac96774bbcceb30200000014',X'01890a5dac96774bbcceb3020000001e',X'1900eab6c028483d7126599ee6f50de0d27907b5c65fa90524580b4b0f9852b0',5,1,0,3300,3400,X'7469636b6574',X'686561646572206f662061207265636f7264696e67',X'1993a3c633cf3e4fd898beaccbf56c1544235cd8f97396e3cbe30952502a5167',7,2,500,0,92,X'bdd3d227437a93b23a9217c7109e6401f17efc0b8c55a8eabc2153cf54ae3e94',1.0,'',100.0,0,X'a575b79868a2336db378ac89cb6c7d93272b4bb8e74d1096e8630765cf480ef5',X'2443630b4620165c8b173e7265e17526fe2787ae594364dd6d839ad58f2fc007',X'763cdc62a869262b6ff432a40eae29a00bb96f96f7a3320845abc8cd144d12e2',X'9cda38ea3a2bd78cbaecd4b8bbd646abc14cee8d99c59860ac2a301f722b8be0',X'01890a5dac96774bbcceb3020000002a',0,X'01890a5dac96774bbcceb30200000051',0,0,0,0,0,2,80.0,'measured by hand',X'01890a5dac96774bbcceb30200000001',5300,1,'{}',4,0,'','','');
INSERT INTO attempts VALUES(1,X'01890a5dac96774bbcceb3020000002b',X'01890a5dac96774bbcceb30200000002',X'01890a5dac96774bbcceb30200000014',X'01890a5dac96774bbcceb3020000001e',X'1900eab6c028483d7126599ee6f50de0d27907b5c65fa90524580b4b0f9852b0',5,0,1,3500,3600,X'7469636b6574',X'686561646572206f662061207265636f7264696e67',X'1993a3c633cf3e4fd898beaccbf56c1544235cd8f97396e3cbe30952502a5167',0,2,500,0,92,X'bdd3d227437a93b23a9217c7109e6401f17efc0b8c55a8eabc2153cf54ae3e94',1.0,'',71.5,1,X'cb872a6cdb514d8ef46514b6f4650f3ed5c179154f24d2d34e2b8d8908df8035',X'2443630b4620165c8b173e7265e17526fe2787ae594364dd6d839ad58f2fc007',X'763cdc62a869262b6ff432a40eae29a00bb96f96f7a3320845abc8cd144d12e2',X'9cda38ea3a2bd78cbaecd4b8bbd646abc14cee8d99c59860ac2a301f722b8be0',X'01890a5dac96774bbcceb3020000002a',0,X'01890a5dac96774bbcceb30200000051',0,0,0,0,0,2,80.0,'measured by hand',X'01890a5dac96774bbcceb30200000001',5300,1,'{}',4,1,'omega.3','hid','hid:1209:0001:A7');
INSERT INTO attempts VALUES(1,X'01890a5dac96774bbcceb3020000002c',X'01890a5dac96774bbcceb30200000002',X'01890a5dac96774bbcceb30200000014',X'01890a5dac96774bbcceb3020000001f',X'1900eab6c028483d7126599ee6f50de0d27907b5c65fa90524580b4b0f9852b0',6,0,0,3700,3800,X'7469636b6574',X'686561646572206f662061207265636f7264696e67',NULL,0,2,500,0,0,X'bdd3d227437a93b23a9217c7109e6401f17efc0b8c55a8eabc2153cf54ae3e94',0.0,'no reference yet',NULL,0,NULL,NULL,NULL,NULL,NULL,0,NULL,0,0,0,0,0,0,NULL,'',NULL,0,1,'{}',4,0,'','','');
INSERT INTO attempts VALUES(1,X'01890a5dac96774bbcceb3020000002d',X'01890a5dac96774bbcceb30200000002',X'01890a5dac96774bbcceb30200000014',X'01890a5dac96774bbcceb3020000001e',X'1900eab6c028483d7126599ee6f50de0d27907b5c65fa90524580b4b0f9852b0',7,0,0,3900,0,X'7469636b6574',X'686561646572206f662061207265636f7264696e67',X'3887e4ff4cb117983b927fde9da0c0818813a3d587b053db40fe6d951f6a3f47',0,1,250,0,0,NULL,0.0,'chunk 0 came twice',NULL,0,NULL,NULL,NULL,NULL,NULL,0,NULL,0,0,0,0,0,0,NULL,'',NULL,0,1,'{}',4,0,'','','');
CREATE TABLE audit (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  id          BLOB NOT NULL CHECK (length(id) = 16),
  at_ms       INTEGER NOT NULL,
  actor       BLOB NOT NULL CHECK (length(actor) = 16),    -- zero: the system or the command line
  via         TEXT NOT NULL,
  action      TEXT NOT NULL,
  object      TEXT NOT NULL,
  before_json TEXT NOT NULL,
  after_json  TEXT NOT NULL, subject TEXT NOT NULL DEFAULT '', state TEXT NOT NULL DEFAULT '', salt BLOB CHECK (length(salt) = 32), content_hash BLOB CHECK (length(content_hash) = 32), signature BLOB CHECK (length(signature) = 64), chain BLOB CHECK (length(chain) = 16), number INTEGER CHECK (number > 0), previous BLOB CHECK (length(previous) = 32),
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO audit VALUES(1,X'01890a5dac96774bbcceb30200000046',5000,X'01890a5dac96774bbcceb30200000001','page','attempt.release','01890a5d-ac96-774b-bcce-b30200000043','{"released":"no"}','{"released":"yes"}','','',NULL,NULL,NULL,NULL,NULL,NULL);
INSERT INTO audit VALUES(1,X'01890a5dac96774bbcceb30200000080',900,X'01890a5dac96774bbcceb30200000001','station Bench 1','attempt.ticket','01890a5d-ac96-774b-bcce-b3020000002a','{}','{"person":"01890a5d-ac96-774b-bcce-b30200000001","exercise":"01890a5d-ac96-774b-bcce-b3020000001e","assignment":"","exam":"no"}','','',NULL,NULL,NULL,NULL,NULL,NULL);
INSERT INTO audit VALUES(1,X'01890a5dac96774bbcceb30200000081',5100,X'01890a5dac96774bbcceb30200000001','page','appeal.file','01890a5d-ac96-774b-bcce-b3020000002a','{}','{"text":"please look again"}','','',NULL,NULL,NULL,NULL,NULL,NULL);
INSERT INTO audit VALUES(1,X'01890a5dac96774bbcceb30200000082',5200,X'01890a5dac96774bbcceb30200000003','page','cohort.create','01890a5d-ac96-774b-bcce-b3020000000a','{}','{"name":"year 3"}','','',NULL,NULL,NULL,NULL,NULL,NULL);
CREATE TABLE cohort_members (
  tenant INTEGER NOT NULL,
  cohort BLOB NOT NULL,
  person BLOB NOT NULL,
  PRIMARY KEY (tenant, cohort, person),
  FOREIGN KEY (tenant, cohort) REFERENCES cohorts (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO cohort_members VALUES(1,X'01890a5dac96774bbcceb3020000000a',X'01890a5dac96774bbcceb30200000001');
INSERT INTO cohort_members VALUES(1,X'01890a5dac96774bbcceb3020000000a',X'01890a5dac96774bbcceb30200000002');
CREATE TABLE cohorts (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  id         BLOB NOT NULL CHECK (length(id) = 16),
  name       TEXT NOT NULL, revision INTEGER NOT NULL DEFAULT 1, archived_ms INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name)
) STRICT, WITHOUT ROWID;
INSERT INTO cohorts VALUES(1,X'01890a5dac96774bbcceb3020000000a','Year 1',1,0);
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
INSERT INTO contradicting_chunks VALUES(1,X'01890a5dac96774bbcceb3020000002d',0,X'd9298a10d1b0735837dc4bd85dac641b0f3cef27a47e5d53a54f2f3f5b2fcffa',X'616e6f74686572206669727374206368756e6b',3960);
CREATE TABLE erasures (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  person_hash BLOB NOT NULL CHECK (length(person_hash) = 32),
  erased_ms   INTEGER NOT NULL,
  PRIMARY KEY (tenant, person_hash)
) STRICT, WITHOUT ROWID;
INSERT INTO erasures VALUES(1,X'000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f',9000);
CREATE TABLE exercises (
  tenant       INTEGER NOT NULL REFERENCES tenants (tenant),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  name         TEXT NOT NULL,
  version      INTEGER NOT NULL,
  title        TEXT NOT NULL,
  content      BLOB NOT NULL CHECK (length(content) = 32),
  scene        BLOB NOT NULL,
  graded       INTEGER NOT NULL CHECK (graded IN (0, 1)),
  published_ms INTEGER NOT NULL, state INTEGER NOT NULL DEFAULT 2
  CHECK (state BETWEEN 1 AND 3), revision INTEGER NOT NULL DEFAULT 1,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, name, version),
  FOREIGN KEY (tenant, scene) REFERENCES scenes (tenant, content)
) STRICT, WITHOUT ROWID;
INSERT INTO exercises VALUES(1,X'01890a5dac96774bbcceb3020000001e','class-1',1,'Class I',X'e25415e7709cac9edced78040ba02eb1e98eea2748fa4ed5e61de3f6b8e04b64',X'4f48f7207cebf92638debb5694e4a8677350cf88a9e98e73c6c466b6b1d43890',1,2700,2,1);
INSERT INTO exercises VALUES(1,X'01890a5dac96774bbcceb3020000001f','class-1',2,'Class I, smaller',X'9b97701ba1ff396256c8c34e83688278a12d96c840c95162f7e9d90e820e1965',X'4f48f7207cebf92638debb5694e4a8677350cf88a9e98e73c6c466b6b1d43890',0,2800,2,1);
CREATE TABLE people (
  tenant       INTEGER NOT NULL REFERENCES tenants (tenant),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  login        TEXT NOT NULL,
  display_name TEXT NOT NULL,
  role         INTEGER NOT NULL CHECK (role BETWEEN 1 AND 3),  -- 1 student, 2 instructor, 3 admin
  disabled     INTEGER NOT NULL DEFAULT 0 CHECK (disabled IN (0, 1)),
  created_ms   INTEGER NOT NULL,
  verifier     TEXT NOT NULL, revision INTEGER NOT NULL DEFAULT 1, must_change_password INTEGER NOT NULL DEFAULT 0
  CHECK (must_change_password IN (0, 1)), password_ms INTEGER NOT NULL DEFAULT 0, password_used INTEGER NOT NULL DEFAULT 0 CHECK (password_used IN (0, 1)), language TEXT NOT NULL DEFAULT '' CHECK (language IN ('', 'en', 'de', 'zh')),                                  -- argon2id, libsodium's form
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, login)
) STRICT, WITHOUT ROWID;
INSERT INTO people VALUES(1,X'01890a5dac96774bbcceb30200000001','ada','Ada Example',2,0,1000,'$argon2id$v=19$m=8,t=1,p=1$ada',1,0,0,0,'');
INSERT INTO people VALUES(1,X'01890a5dac96774bbcceb30200000002','sam','Sam Example',1,0,1001,'$argon2id$v=19$m=8,t=1,p=1$sam',1,0,0,0,'de');
INSERT INTO people VALUES(1,X'01890a5dac96774bbcceb30200000003','root','Admin',3,0,1002,'$argon2id$v=19$m=8,t=1,p=1$root',1,0,0,0,'');
INSERT INTO people VALUES(1,X'01890a5dac96774bbcceb30200000004','tom','Tom Example',1,1,1003,'$argon2id$v=19$m=8,t=1,p=1$tom',1,1,1795261976000,0,'');
CREATE TABLE profiles (
  tenant  INTEGER NOT NULL REFERENCES tenants (tenant),
  name    TEXT NOT NULL,
  title   TEXT NOT NULL,
  content BLOB NOT NULL CHECK (length(content) = 32),
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;
INSERT INTO profiles VALUES(1,'phantom_desktop','Phantom Desktop',X'1900eab6c028483d7126599ee6f50de0d27907b5c65fa90524580b4b0f9852b0');
CREATE TABLE reference_cuts (
  tenant     INTEGER NOT NULL,
  id         BLOB NOT NULL CHECK (length(id) = 16),
  exercise   BLOB NOT NULL,
  attempt    BLOB NOT NULL,
  dentist    TEXT NOT NULL,
  version    INTEGER NOT NULL,
  created_ms INTEGER NOT NULL, consent INTEGER NOT NULL DEFAULT 1
  CHECK (consent IN (0, 1)), withdrawn_ms INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, exercise, version),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO reference_cuts VALUES(1,X'01890a5dac96774bbcceb30200000032',X'01890a5dac96774bbcceb3020000001e',X'01890a5dac96774bbcceb3020000002a','Dr. Example',1,4000,1,0);
CREATE TABLE retention_rules (
  tenant INTEGER NOT NULL REFERENCES tenants (tenant),
  what   TEXT NOT NULL CHECK (what IN ('unfinished', 'recordings', 'attempts')),
  days   INTEGER NOT NULL CHECK (days BETWEEN 1 AND 36500),
  PRIMARY KEY (tenant, what)
) STRICT, WITHOUT ROWID;
INSERT INTO retention_rules VALUES(1,'recordings',730);
CREATE TABLE scenes (
  tenant  INTEGER NOT NULL REFERENCES tenants (tenant),
  name    TEXT NOT NULL,
  title   TEXT NOT NULL,
  content BLOB NOT NULL CHECK (length(content) = 32),
  volume  BLOB NOT NULL CHECK (length(volume) = 32), surface BLOB CHECK (length(surface) = 32),
  PRIMARY KEY (tenant, content)
) STRICT, WITHOUT ROWID;
INSERT INTO scenes VALUES(1,'molar','Molar',X'4f48f7207cebf92638debb5694e4a8677350cf88a9e98e73c6c466b6b1d43890',X'62d7a6b1211d627650e2bf0c869b69b564e2cd74290ae1dd78ae4b5e20b0cfe7',NULL);
CREATE TABLE stations (
  tenant          INTEGER NOT NULL REFERENCES tenants (tenant),
  id              BLOB NOT NULL CHECK (length(id) = 16),
  name            TEXT NOT NULL,
  public_key      BLOB NOT NULL CHECK (length(public_key) = 32),  -- Ed25519, checks chunks
  credential_hash BLOB NOT NULL CHECK (length(credential_hash) = 32),
  revoked         INTEGER NOT NULL DEFAULT 0 CHECK (revoked IN (0, 1)),
  enrolled_ms     INTEGER NOT NULL,
  last_seen_ms    INTEGER NOT NULL, revision INTEGER NOT NULL DEFAULT 1, revoked_ms INTEGER NOT NULL DEFAULT 0, software TEXT NOT NULL DEFAULT '', core_version INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO stations VALUES(1,X'01890a5dac96774bbcceb30200000014','Bench 1',X'000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f',X'e265b6f564601a1fe8dc42785cd18a868bd8013eb5899560e79248767a683e6b',0,2500,2600,1,0,'',0);
CREATE TABLE tenants (
  tenant INTEGER NOT NULL PRIMARY KEY,
  name   TEXT NOT NULL
) STRICT;
INSERT INTO tenants VALUES(1,'default');
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
INSERT INTO trace_chunks VALUES(1,X'01890a5dac96774bbcceb30200000029',0,X'3887e4ff4cb117983b927fde9da0c0818813a3d587b053db40fe6d951f6a3f47',X'6669727374206368756e6b2c206173207468652073746174696f6e2073656e74206974',3200);
INSERT INTO trace_chunks VALUES(1,X'01890a5dac96774bbcceb30200000029',1,X'1993a3c633cf3e4fd898beaccbf56c1544235cd8f97396e3cbe30952502a5167',X'7365636f6e64206368756e6b2c206173207468652073746174696f6e2073656e74206974',3201);
INSERT INTO trace_chunks VALUES(1,X'01890a5dac96774bbcceb3020000002d',0,X'3887e4ff4cb117983b927fde9da0c0818813a3d587b053db40fe6d951f6a3f47',X'6669727374206368756e6b2c206173207468652073746174696f6e2073656e74206974',3950);
CREATE TABLE IF NOT EXISTS "assignments" (
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
  created_ms    INTEGER NOT NULL DEFAULT 0, hands INTEGER NOT NULL DEFAULT 4, exercise BLOB CHECK (length(exercise) = 16), counting TEXT NOT NULL DEFAULT 'best'
  CHECK (counting IN ('best', 'last', 'mean', 'median')),
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO assignments VALUES(1,X'01890a5dac96774bbcceb30200000050','class-1',X'01890a5dac96774bbcceb3020000000a',0,0,0,0,0,1,0,4,X'01890a5dac96774bbcceb3020000001f','best');
INSERT INTO assignments VALUES(1,X'01890a5dac96774bbcceb30200000051','class-1',X'01890a5dac96774bbcceb3020000000a',1000,9000,2,1,0,3,900,1,X'01890a5dac96774bbcceb3020000001f','best');
CREATE TABLE assignment_stations (
  tenant     INTEGER NOT NULL,
  assignment BLOB NOT NULL,
  station    BLOB NOT NULL,
  PRIMARY KEY (tenant, assignment, station),
  FOREIGN KEY (tenant, assignment) REFERENCES assignments (tenant, id) ON DELETE CASCADE,
  FOREIGN KEY (tenant, station) REFERENCES stations (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO assignment_stations VALUES(1,X'01890a5dac96774bbcceb30200000051',X'01890a5dac96774bbcceb30200000014');
CREATE TABLE attempt_results (
  tenant        INTEGER NOT NULL,
  attempt       BLOB NOT NULL,
  run           INTEGER NOT NULL,
  scored_ms     INTEGER NOT NULL,
  cause         TEXT NOT NULL,   -- of the job: "seal", "reference", "rescore", "appeal"
  score         REAL NOT NULL,
  critical_fail INTEGER NOT NULL CHECK (critical_fail IN (0, 1)),
  score_json    BLOB NOT NULL,
  reference     BLOB, replay_realtime_factor REAL NOT NULL DEFAULT 0, document BLOB, final_volume BLOB CHECK (length(final_volume) = 32), surface BLOB CHECK (length(surface) = 32), series BLOB CHECK (length(series) = 32),            -- the attempt it was compared with
  PRIMARY KEY (tenant, attempt, run),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO attempt_results VALUES(1,X'01890a5dac96774bbcceb3020000002a',1,3400,'seal',100.0,0,X'a575b79868a2336db378ac89cb6c7d93272b4bb8e74d1096e8630765cf480ef5',X'01890a5dac96774bbcceb3020000002a',0.0,NULL,X'2443630b4620165c8b173e7265e17526fe2787ae594364dd6d839ad58f2fc007',X'763cdc62a869262b6ff432a40eae29a00bb96f96f7a3320845abc8cd144d12e2',X'9cda38ea3a2bd78cbaecd4b8bbd646abc14cee8d99c59860ac2a301f722b8be0');
INSERT INTO attempt_results VALUES(1,X'01890a5dac96774bbcceb3020000002b',1,3600,'seal',71.5,1,X'cb872a6cdb514d8ef46514b6f4650f3ed5c179154f24d2d34e2b8d8908df8035',X'01890a5dac96774bbcceb3020000002a',0.0,NULL,X'2443630b4620165c8b173e7265e17526fe2787ae594364dd6d839ad58f2fc007',X'763cdc62a869262b6ff432a40eae29a00bb96f96f7a3320845abc8cd144d12e2',X'9cda38ea3a2bd78cbaecd4b8bbd646abc14cee8d99c59860ac2a301f722b8be0');
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
  revision   INTEGER NOT NULL DEFAULT 1, to_chair INTEGER NOT NULL DEFAULT 0 CHECK (to_chair IN (0, 1)),
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO annotations VALUES(1,X'01890a5dac96774bbcceb30200000060',X'01890a5dac96774bbcceb3020000002a',X'01890a5dac96774bbcceb30200000001',120,1,-2,3,'too deep here',5000,0,1,1);
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
INSERT INTO appeals VALUES(1,X'01890a5dac96774bbcceb3020000002a',5100,'please look again','rejected','no',X'01890a5dac96774bbcceb30200000001',5200);
CREATE TABLE IF NOT EXISTS "jobs" (
  tenant         INTEGER NOT NULL,
  id             BLOB NOT NULL CHECK (length(id) = 16),
  kind           TEXT NOT NULL,
  attempt        BLOB NOT NULL,
  cause          TEXT NOT NULL DEFAULT 'seal',
  state          TEXT NOT NULL CHECK (state IN ('queued', 'running', 'done', 'failed', 'cancelled')),
  tries          INTEGER NOT NULL DEFAULT 0,
  lease_until_ms INTEGER NOT NULL DEFAULT 0,
  error          TEXT NOT NULL DEFAULT '', batch BLOB, lease BLOB CHECK (length(lease) = 16), owner BLOB CHECK (length(owner) = 16),
  PRIMARY KEY (tenant, id),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO jobs VALUES(1,X'01890a5dac96774bbcceb3020000003c','score',X'01890a5dac96774bbcceb3020000002b','seal','done',1,0,'',X'01890a5dac96774bbcceb30200000090',X'01890a5dac96774bbcceb30200000090',X'01890a5dac96774bbcceb30200000091');
INSERT INTO jobs VALUES(1,X'01890a5dac96774bbcceb3020000003d','score',X'01890a5dac96774bbcceb3020000002c','seal','queued',2,0,'disk full',NULL,NULL,NULL);
CREATE TABLE IF NOT EXISTS "sessions" (
  tenant       INTEGER NOT NULL,
  token_hash   BLOB NOT NULL CHECK (length(token_hash) = 32),
  id           BLOB NOT NULL CHECK (length(id) = 16),
  person       BLOB NOT NULL,
  created_ms   INTEGER NOT NULL,
  last_used_ms INTEGER NOT NULL,
  expires_ms   INTEGER NOT NULL,
  confirmed_ms INTEGER NOT NULL,
  via          TEXT NOT NULL, address TEXT NOT NULL DEFAULT '', device TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (tenant, token_hash),
  UNIQUE (tenant, id),
  FOREIGN KEY (tenant, person) REFERENCES people (tenant, id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;
INSERT INTO sessions VALUES(1,X'3c469e9d6c5875d37a43f353d4f88e61fcf812c66eee3457465a40b0da4153e0',X'21fe5ef90dfc54feae9b18fb8898c6fb',X'01890a5dac96774bbcceb30200000002',2000,2001,9000000000000,2000,'page','','');
CREATE TABLE IF NOT EXISTS "enrol_codes" (
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
INSERT INTO enrol_codes VALUES(1,X'2348f998744212575d85959674f9607ab26f67708a917157472832386337c904',X'30b4f0a7118a82a8dda5b055bd0cb62b',0,3000,NULL,NULL);
INSERT INTO enrol_codes VALUES(1,X'f839161355091fcd9e33f571e0b11c60217a5009f9973e769c13d7858db162cc',X'7a42469f824edb10ddbeb576359bf5d8',0,3000,2500,NULL);
CREATE TABLE profile_versions (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  name       TEXT NOT NULL,
  version    INTEGER NOT NULL CHECK (version >= 1),
  title      TEXT NOT NULL,
  content    BLOB NOT NULL CHECK (length(content) = 32),
  created_ms INTEGER NOT NULL,                       -- 0: before schema 4
  PRIMARY KEY (tenant, name, version)
) STRICT, WITHOUT ROWID;
INSERT INTO profile_versions VALUES(1,'phantom_desktop',1,'Phantom Desktop',X'1900eab6c028483d7126599ee6f50de0d27907b5c65fa90524580b4b0f9852b0',0);
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
INSERT INTO profile_reports VALUES(1,X'01890a5dac96774bbcceb30200000083','phantom_desktop',1,'text/html',X'1900eab6c028483d7126599ee6f50de0d27907b5c65fa90524580b4b0f9852b0',3,5300);
CREATE TABLE calibrations (
  tenant      INTEGER NOT NULL,
  id          BLOB NOT NULL CHECK (length(id) = 16),
  profile     TEXT NOT NULL,
  device      TEXT NOT NULL,
  measured_ms INTEGER NOT NULL,
  added_ms    INTEGER NOT NULL,
  document    TEXT NOT NULL,
  PRIMARY KEY (tenant, id),
  UNIQUE (tenant, profile, document),
  FOREIGN KEY (tenant, profile) REFERENCES profiles (tenant, name)
) STRICT, WITHOUT ROWID;
INSERT INTO calibrations VALUES(1,X'01890a5dac96774bbcceb30200000084','phantom_desktop','bench 1',5400,5500,'{}');
CREATE TABLE write_probe (
  tenant INTEGER NOT NULL PRIMARY KEY,
  at_ms  INTEGER NOT NULL
) STRICT;
INSERT INTO write_probe VALUES(1,3000);
CREATE TABLE rubrics (
  tenant       INTEGER NOT NULL,
  exercise     BLOB NOT NULL,                             -- this version of it
  version      INTEGER NOT NULL CHECK (version > 1),      -- of the document, as scores name it
  content      BLOB NOT NULL CHECK (length(content) = 32),
  reason       TEXT NOT NULL,
  published_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, exercise, version),
  FOREIGN KEY (tenant, exercise) REFERENCES exercises (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO rubrics VALUES(1,X'01890a5dac96774bbcceb3020000001f',2,X'9b97701ba1ff396256c8c34e83688278a12d96c840c95162f7e9d90e820e1965','full marks were out of reach',1790000000000);
CREATE TABLE job_batches (
  tenant    INTEGER NOT NULL REFERENCES tenants (tenant),
  id        BLOB NOT NULL CHECK (length(id) = 16),
  title     TEXT NOT NULL,                                -- for people: "Year 2, class-1-molar"
  cohort    BLOB,                                         -- whose attempts they are
  cause     TEXT NOT NULL,                                -- of its jobs
  queued_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO job_batches VALUES(1,X'01890a5dac96774bbcceb30200000090','Year 2',NULL,'rubric',1790000000000);
CREATE TABLE listed_devices (
  tenant   INTEGER NOT NULL REFERENCES tenants (tenant),
  name     TEXT NOT NULL,
  title    TEXT NOT NULL,                                 -- for people: "chair 3"
  added_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;
INSERT INTO listed_devices VALUES(1,'hid:1209:0001:A7','chair 3',1700000000000);
CREATE TABLE exercise_owners (
  tenant INTEGER NOT NULL REFERENCES tenants (tenant),
  name   TEXT NOT NULL,
  owner  BLOB,                                            -- a person; NULL: the school's, hence the admins'
  shared INTEGER NOT NULL CHECK (shared IN (0, 1)),       -- other instructors may read and assign it
  PRIMARY KEY (tenant, name),
  FOREIGN KEY (tenant, owner) REFERENCES people (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO exercise_owners VALUES(1,'class-1',NULL,1);
CREATE TABLE audit_to_begin (
  tenant INTEGER NOT NULL PRIMARY KEY
) STRICT;
INSERT INTO audit_to_begin VALUES(1);
CREATE TABLE timelines (
  tenant  INTEGER NOT NULL,
  attempt BLOB NOT NULL,
  content BLOB CHECK (length(content) = 32),  -- NULL: not made
  tries   INTEGER NOT NULL DEFAULT 0,         -- begun, of those that did not end with it
  problem TEXT NOT NULL DEFAULT '', owner BLOB CHECK (length(owner) = 16), lease_until_ms INTEGER NOT NULL DEFAULT 0,           -- why the last try failed
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO timelines VALUES(1,X'01890a5dac96774bbcceb3020000002a',NULL,0,'',NULL,0);
INSERT INTO timelines VALUES(1,X'01890a5dac96774bbcceb3020000002b',X'94d192b3a326be1f019b71ef13ea5a367ffe939c5e9a88f1b270e53753d9569a',1,'',NULL,0);
CREATE TABLE start_teeth (
  tenant  INTEGER NOT NULL REFERENCES tenants (tenant),
  volume  BLOB NOT NULL CHECK (length(volume) = 32),
  content BLOB NOT NULL CHECK (length(content) = 32),
  PRIMARY KEY (tenant, volume)
) STRICT, WITHOUT ROWID;
INSERT INTO start_teeth VALUES(1,X'62d7a6b1211d627650e2bf0c869b69b564e2cd74290ae1dd78ae4b5e20b0cfe7',X'1d7f2580c876ab639ce65739ecac2e807a5cf356dcc1ae8d129a16d9f43fe3f9');
CREATE TABLE motions (
  tenant     INTEGER NOT NULL,
  attempt    BLOB NOT NULL,
  content    BLOB NOT NULL CHECK (length(content) = 32),
  nearest    BLOB CHECK (length(nearest) = 16),  -- an attempt; NULL: there was none before it, or it is erased
  others     INTEGER NOT NULL,                   -- it was compared with so many
  nearest_um INTEGER NOT NULL,
  median_um  INTEGER NOT NULL,
  size_um    INTEGER NOT NULL,
  PRIMARY KEY (tenant, attempt),
  FOREIGN KEY (tenant, attempt) REFERENCES attempts (tenant, id)
) STRICT, WITHOUT ROWID;
INSERT INTO motions VALUES(1,X'01890a5dac96774bbcceb3020000002a',X'9b97701ba1ff396256c8c34e83688278a12d96c840c95162f7e9d90e820e1965',NULL,0,0,0,20000);
CREATE TABLE audit_heads (
  tenant    INTEGER NOT NULL,
  chain     BLOB NOT NULL CHECK (length(chain) = 16),
  number    INTEGER NOT NULL CHECK (number > 0),      -- of its last row
  last_id   BLOB NOT NULL CHECK (length(last_id) = 16),
  hash      BLOB NOT NULL CHECK (length(hash) = 32),
  signature BLOB NOT NULL CHECK (length(signature) = 64),
  PRIMARY KEY (tenant, chain)
) STRICT, WITHOUT ROWID;
CREATE TABLE blobs (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  hash       BLOB NOT NULL CHECK (length(hash) = 32),   -- SHA-256 of the bytes: the blob's name
  generation INTEGER NOT NULL CHECK (generation > 0),   -- at random; the object is <hash>-<generation>
  put_ms     INTEGER NOT NULL,                          -- the last time that somebody put or named it
  PRIMARY KEY (tenant, hash)
) STRICT, WITHOUT ROWID;
INSERT INTO blobs VALUES(1,X'000000000000000000000000000000000000000000000000000000000000007b',4711,6000);
CREATE TABLE person_keys (
  tenant     INTEGER NOT NULL REFERENCES tenants (tenant),
  person     BLOB NOT NULL CHECK (length(person) = 16),
  generation INTEGER NOT NULL CHECK (generation > 0),   -- at random; the object is <uuid>-<generation>
  hash       BLOB NOT NULL CHECK (length(hash) = 32),   -- SHA-256 of the object
  made_ms    INTEGER NOT NULL,
  PRIMARY KEY (tenant, person)
) STRICT, WITHOUT ROWID;
INSERT INTO person_keys VALUES(1,X'01890a5dac96774bbcceb30200000002',4660,X'abababababababababababababababababababababababababababababababab',1700000000000);
CREATE TABLE server_identity (
  tenant      INTEGER NOT NULL REFERENCES tenants (tenant),
  name        TEXT NOT NULL CHECK (name IN ('station_certificate', 'ticket_key', 'key_ring')),
  fingerprint BLOB NOT NULL CHECK (length(fingerprint) = 32),
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;
INSERT INTO server_identity VALUES(1,'key_ring',X'cdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcdcd');
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
INSERT INTO sign_in_counters VALUES(1,X'0000000000000000000000000000000000000000000000000000000000000000',3,1,1790000000000,1790000001000,1790000900000);
CREATE TABLE leases (
  tenant   INTEGER NOT NULL REFERENCES tenants (tenant),
  name     TEXT NOT NULL CHECK (name IN ('upkeep')),
  lease    BLOB NOT NULL CHECK (length(lease) = 16),  -- of this holding of it
  until_ms INTEGER NOT NULL,
  PRIMARY KEY (tenant, name)
) STRICT, WITHOUT ROWID;
INSERT INTO leases VALUES(1,'upkeep',X'000102030405060708090a0b0c0d0e0f',1790000030000);
CREATE TABLE rewrite_due (
  tenant   INTEGER NOT NULL PRIMARY KEY REFERENCES tenants (tenant),
  since_ms INTEGER NOT NULL,
  mark     BLOB NOT NULL CHECK (length(mark) = 16)  -- of whoever erased last
) STRICT;
INSERT INTO rewrite_due VALUES(1,1790000000000,X'0f0e0d0c0b0a09080706050403020100');
CREATE INDEX cohort_members_by_person ON cohort_members (tenant, person);
CREATE INDEX exercises_by_content ON exercises (tenant, content);
CREATE INDEX attempts_by_person ON attempts (tenant, person, id);
CREATE INDEX attempts_by_exercise ON attempts (tenant, exercise, id);
CREATE INDEX attempts_by_reference ON attempts (tenant, reference) WHERE reference IS NOT NULL;
CREATE INDEX assignments_by_exercise ON assignments (tenant, exercise_name, cohort);
CREATE INDEX attempts_by_assignment ON attempts (tenant, assignment, person) WHERE assignment IS NOT NULL;
CREATE INDEX annotations_by_attempt ON annotations (tenant, attempt, tick, id);
CREATE INDEX appeals_open ON appeals (tenant, filed_ms) WHERE state = 'open';
CREATE INDEX jobs_open ON jobs (tenant, id) WHERE state IN ('queued', 'running');
CREATE INDEX jobs_by_attempt ON jobs (tenant, attempt, id);
CREATE INDEX people_by_role ON people (tenant, role, login);
CREATE INDEX sessions_by_person ON sessions (tenant, person);
CREATE INDEX calibrations_by_profile ON calibrations (tenant, profile, measured_ms);
CREATE INDEX audit_by_object ON audit (tenant, object, id);
CREATE INDEX audit_by_actor ON audit (tenant, actor, id);
CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
BEGIN
  SELECT RAISE(ABORT, 'audit rows are never deleted');
END;
CREATE INDEX jobs_by_batch ON jobs (tenant, batch) WHERE batch IS NOT NULL;
CREATE INDEX audit_by_subject ON audit (tenant, subject, id) WHERE subject <> '';
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
WHEN NOT (
  NEW.tenant = OLD.tenant AND NEW.id = OLD.id AND NEW.at_ms = OLD.at_ms AND NEW.actor = OLD.actor AND
  NEW.via = OLD.via AND NEW.action = OLD.action AND NEW.object = OLD.object AND NEW.subject = OLD.subject AND
  NEW.content_hash IS OLD.content_hash AND NEW.signature IS OLD.signature AND NEW.salt IS NULL AND
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
CREATE INDEX timelines_to_make ON timelines (tenant, attempt) WHERE content IS NULL;
CREATE INDEX start_teeth_by_content ON start_teeth (tenant, content);
CREATE INDEX motions_by_nearest ON motions (tenant, nearest) WHERE nearest IS NOT NULL;
CREATE UNIQUE INDEX audit_by_number ON audit (tenant, chain, number) WHERE chain IS NOT NULL;
CREATE TRIGGER audit_heads_only_advance BEFORE UPDATE ON audit_heads
WHEN NOT (NEW.tenant = OLD.tenant AND NEW.chain = OLD.chain AND NEW.number > OLD.number)
BEGIN
  SELECT RAISE(ABORT, 'the audit trail only grows');
END;
CREATE TRIGGER audit_heads_are_not_deleted BEFORE DELETE ON audit_heads
BEGIN
  SELECT RAISE(ABORT, 'the audit trail only grows');
END;
CREATE TRIGGER audit_stays_in_place BEFORE UPDATE ON audit
WHEN NOT (NEW.chain IS OLD.chain AND NEW.number IS OLD.number AND NEW.previous IS OLD.previous)
BEGIN
  SELECT RAISE(ABORT, 'audit rows are never changed');
END;
CREATE UNIQUE INDEX jobs_by_lease ON jobs (tenant, lease) WHERE lease IS NOT NULL;
CREATE UNIQUE INDEX jobs_running ON jobs (tenant, attempt) WHERE state = 'running';
CREATE INDEX sign_in_counters_by_end ON sign_in_counters (tenant, until_ms);
COMMIT;
