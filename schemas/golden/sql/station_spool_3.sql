-- The station's spool, version 3 (PRAGMA user_version = 3). Recordings are durable here before they
-- are sent, and stay until the server has had them for a week. WAL, synchronous = FULL. A spool of
-- version 1 is brought here by station_spool_from_1.sql and _from_2.sql; a newer one is refused.

-- One attempt. `header` is the recording's header as sent (schemas/trace_format.md). The seal's
-- columns are NULL until the attempt ended; `sealed_at_server` is set when the server confirmed it.
-- What is counted here is changed in one transaction with the chunks it counts.
CREATE TABLE attempts (
  id                BLOB PRIMARY KEY CHECK (length(id) = 16),
  header            BLOB NOT NULL,
  header_sha256     BLOB NOT NULL CHECK (length(header_sha256) = 32),
  exercise          TEXT NOT NULL,          -- its name, for people
  profile           TEXT NOT NULL,
  created_unix_ms   INTEGER NOT NULL,
  seal_chunks       INTEGER,
  seal_ticks        INTEGER,
  seal_last_sha256  BLOB,
  seal_state_hash   INTEGER,                -- bit pattern of the unsigned hash
  sealed_at_server  INTEGER NOT NULL DEFAULT 0,
  refused           TEXT,                   -- why the server will not have it, in its words
  chunks            INTEGER NOT NULL DEFAULT 0,
  ticks             INTEGER NOT NULL DEFAULT 0,
  gap_ticks         INTEGER NOT NULL DEFAULT 0,
  bytes             INTEGER NOT NULL DEFAULT 0,
  committed         INTEGER NOT NULL DEFAULT 0,  -- the server has the chunks below this one durably
  committed_unix_ms INTEGER NOT NULL DEFAULT 0,  -- when it last said so
  resumed           INTEGER NOT NULL DEFAULT 0,  -- how often it was taken up again after a crash
  -- When its newest chunk became durable (without one: when it was begun), by a time that no clock
  -- that is set changes: which start of the machine, and how long after it. NULL: by version 2.
  boot_id           TEXT,
  boot_ms           INTEGER
) WITHOUT ROWID;

-- One chunk of an attempt, as sent; seq counts from 0 without holes. Idempotent by (attempt, seq,
-- sha256).
CREATE TABLE chunks (
  attempt         BLOB NOT NULL REFERENCES attempts (id) ON DELETE CASCADE,
  seq             INTEGER NOT NULL,
  sha256          BLOB NOT NULL CHECK (length(sha256) = 32),   -- of the unsigned part
  bytes           BLOB NOT NULL,
  ticks           INTEGER NOT NULL,
  gap_ticks       INTEGER NOT NULL,
  spooled_unix_ms INTEGER,                -- when it became durable here; NULL: by version 1
  PRIMARY KEY (attempt, seq)
);

-- Tickets taken in advance, each locked with its person's PIN: `locked` is the ticket
-- (schemas/trace_format.md) under a key made from PIN and salt (station/session/ticket_safe.h). Gone
-- when used and uploaded or revoked. One that is handed back, has expired unused or had too many wrong
-- PINs has an empty `locked` until the server has been told (schemas/wire/README.md, "Returned tickets").
CREATE TABLE tickets (
  attempt         BLOB PRIMARY KEY CHECK (length(attempt) = 16),
  person          TEXT NOT NULL,            -- name to show in the list
  exercise        TEXT NOT NULL,            -- its name
  title           TEXT NOT NULL,
  profile         TEXT NOT NULL,
  expires_unix_ms INTEGER NOT NULL,
  salt            BLOB NOT NULL CHECK (length(salt) = 16),
  locked          BLOB NOT NULL,            -- nonce, then ciphertext and tag
  wrong_pins      INTEGER NOT NULL DEFAULT 0,   -- since the last right one; counted before it is tried
  wait_unix_ms    INTEGER NOT NULL DEFAULT 0    -- no PIN is tried before
) WITHOUT ROWID;
