-- The station's spool: recordings are durable here before they are sent, and stay until the server has
-- had them for a week. WAL, synchronous = FULL. PRAGMA user_version counts the migrations that were run;
-- a spool of a newer program is refused.
--
-- What is said of a table stands before it and not in it: SQLite keeps a table's text, and all of it
-- has to fit into the first page, from which a damaged spool is read (station/spool/salvage.h). For the
-- same reason no migration may move a table: a new spool has each where spools of all versions have it.

-- One attempt. `header` is the recording's header as sent (schemas/trace_format.md); `exercise` and
-- `profile` are names, for people. The seal's columns are NULL until the attempt ended
-- (`seal_state_hash`: bit pattern of the unsigned hash); `sealed_at_server` is set when the server
-- confirmed it.
--   refused              why the server will not have it, in its words
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
  refused             TEXT
) WITHOUT ROWID;

-- One chunk of an attempt, as sent; seq counts from 0 without holes. Idempotent by (attempt, seq,
-- sha256). `sha256` is of the unsigned part. `committed_unix_ms` has gone with 0002.
CREATE TABLE chunks (
  attempt           BLOB NOT NULL REFERENCES attempts (id) ON DELETE CASCADE,
  seq               INTEGER NOT NULL,
  sha256            BLOB NOT NULL CHECK (length(sha256) = 32),
  bytes             BLOB NOT NULL,
  ticks             INTEGER NOT NULL,
  gap_ticks         INTEGER NOT NULL,
  committed_unix_ms INTEGER,
  PRIMARY KEY (attempt, seq)
);
