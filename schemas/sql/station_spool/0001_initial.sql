-- The station's spool: recordings are durable here before they are sent, and stay until the server has
-- had them for a week. WAL, synchronous = FULL. PRAGMA application_id marks the file as a spool
-- (station/spool/spool_file.h), PRAGMA user_version is the schema's version.
--
-- What is said of a table stands before it and not in it: SQLite keeps a table's text, and all of it
-- has to fit into the first page, from which a damaged spool is read (station/spool/salvage.h). For the
-- same reason no migration may move a table: a new spool has each where spools of all versions have it.

-- One attempt. `header` is the recording's header as sent (schemas/trace_format.md); `exercise` and
-- `profile` are names, for people. The seal's columns are NULL until the attempt ended
-- (`seal_state_hash`: bit pattern of the unsigned hash).
--   sealed_at_server     1 when the server confirmed the seal
--   refused              why the server will not have it, in its words; refused_unix_ms: since when
--   chunks to bytes      sums over its chunks, changed in one transaction with them
--   committed            the server has the chunks below this one durably
--   committed_unix_ms    when it last said so
--   resumed              how often it was taken up again after a crash
--   boot_id, boot_ms     when its newest chunk became durable (without one: when it was begun), by a time
--                        that setting the clock does not change: which start of the machine, and how long
--                        after it
--   waits_because        why the last try to send it failed, where another may not; NULL: it went well,
--                        or there was none
--   waits_since_unix_ms  the first of the failed tries in a row
--   tried_unix_ms        the last
--   facts                AttemptFacts (schemas/wire/station.proto), encoded; `resumed` in it does not
--                        count: that is the column
--   sign_off             1 when a second person is to sign its end at the chair
--   outline              1 when the chair may show the target's outline on the tooth
CREATE TABLE attempts (
  id                  BLOB PRIMARY KEY CHECK (length(id) = 16),
  header              BLOB NOT NULL,
  header_sha256       BLOB NOT NULL CHECK (length(header_sha256) = 32),
  exercise            TEXT NOT NULL,
  profile             TEXT NOT NULL,
  created_unix_ms     INTEGER NOT NULL,
  seal_chunks         INTEGER,
  seal_ticks          INTEGER,
  seal_last_sha256    BLOB,
  seal_state_hash     INTEGER,
  sealed_at_server    INTEGER NOT NULL DEFAULT 0,
  refused             TEXT,
  refused_unix_ms     INTEGER,
  chunks              INTEGER NOT NULL DEFAULT 0,
  ticks               INTEGER NOT NULL DEFAULT 0,
  gap_ticks           INTEGER NOT NULL DEFAULT 0,
  bytes               INTEGER NOT NULL DEFAULT 0,
  committed           INTEGER NOT NULL DEFAULT 0,
  committed_unix_ms   INTEGER NOT NULL DEFAULT 0,
  resumed             INTEGER NOT NULL DEFAULT 0,
  boot_id             TEXT NOT NULL,
  boot_ms             INTEGER NOT NULL,
  waits_because       TEXT,
  waits_since_unix_ms INTEGER,
  tried_unix_ms       INTEGER,
  facts               BLOB NOT NULL DEFAULT x'',
  sign_off            INTEGER NOT NULL DEFAULT 0,
  outline             INTEGER NOT NULL DEFAULT 0
) WITHOUT ROWID;

-- One chunk of an attempt, as sent; seq counts from 0 without holes. Idempotent by (attempt, seq,
-- sha256). `sha256` is of the unsigned part. `spooled_unix_ms`: when it became durable here.
CREATE TABLE chunks (
  attempt         BLOB NOT NULL REFERENCES attempts (id) ON DELETE CASCADE,
  seq             INTEGER NOT NULL,
  sha256          BLOB NOT NULL CHECK (length(sha256) = 32),
  bytes           BLOB NOT NULL,
  ticks           INTEGER NOT NULL,
  gap_ticks       INTEGER NOT NULL,
  spooled_unix_ms INTEGER NOT NULL,
  PRIMARY KEY (attempt, seq)
);

-- Tickets taken in advance, each locked with its person's PIN: `locked` is the ticket
-- (schemas/trace_format.md) under a key made from PIN and salt (station/session/ticket_safe.h): nonce,
-- then ciphertext and tag. Gone when used and uploaded or revoked. One that is handed back, has expired
-- unused or had too many wrong PINs has an empty `locked` until the server has been told
-- (schemas/wire/README.md, "Returned tickets"). `person` is the name to show in the list, `exercise` the
-- exercise's name. `wrong_pins`: since the last right one, counted before it is tried; no PIN is tried
-- before `wait_unix_ms`. `hands`: what may hold the tool, as the server said with the ticket
-- (schemas/wire/station.proto, TicketIssued.hands): 1 devices on the school's list, 2 every haptic
-- device, 3 a mouse too, 4 anything.
CREATE TABLE tickets (
  attempt         BLOB PRIMARY KEY CHECK (length(attempt) = 16),
  person          TEXT NOT NULL,
  exercise        TEXT NOT NULL,
  title           TEXT NOT NULL,
  profile         TEXT NOT NULL,
  expires_unix_ms INTEGER NOT NULL,
  salt            BLOB NOT NULL CHECK (length(salt) = 16),
  locked          BLOB NOT NULL,
  wrong_pins      INTEGER NOT NULL DEFAULT 0,
  wait_unix_ms    INTEGER NOT NULL DEFAULT 0,
  hands           INTEGER NOT NULL,
  outline         INTEGER NOT NULL DEFAULT 0
) WITHOUT ROWID;

-- How the loop went that recorded an attempt (schemas/loop_facts.md): `run` 0 as it was begun, n after
-- it was resumed n times. A run that a crash ended has none.
CREATE TABLE loop_facts (
  attempt       BLOB NOT NULL REFERENCES attempts (id) ON DELETE CASCADE,
  run           INTEGER NOT NULL,
  ended_unix_ms INTEGER NOT NULL,
  facts         TEXT NOT NULL,
  PRIMARY KEY (attempt, run)
);
